function failed = leakref_check(code, folder, times)
% LEAKREF_CHECK  Compares your functions with the golden values in this folder (MATLAB R2016b, Octave 6, or later).
%
%   failed = leakref_check(struct('window', @my_window, 'dispersion', @my_dispersion))
%
% where each function is that of a stage, with _ for - in its name. It is handed the inputs of a vector, as fields of a
% structure with its id, and returns a structure of the outputs, or the one there is. @(stage, given) for all of them does
% as well, [] being no answer. A table of ids, digits that agree, and pass or FAIL is printed; failed is how many fell
% short. What is allowed is `times` the tolerance of the set, 1 unless it is given.
  if nargin < 2 || isempty(folder), folder = fileparts(mfilename('fullpath')); end
  if nargin < 3, times = 1; end
  tab = sprintf('\t');
  lines = strsplit(strtrim(fileread(fullfile(folder, 'vectors.tsv'))), sprintf('\n'));
  head = strsplit(lines{1}, tab);
  if ~strcmp(head{1}, 'leakref/pack/1') || ~any(strcmp(head{2}, {'raw', 'mat'}))
    error('vectors.tsv is no pack in raw or mat: have it written with --format raw or mat');
  end
  [failed, compared] = deal(0);
  for n = 3:numel(lines)
    cells = strsplit(lines{n}, tab);
    stage = cells{2};
    if isstruct(code) && ~isfield(code, strrep(stage, '-', '_')), continue; end
    [given, golden] = both(cells, folder, head{2});
    why = '';
    try
      if isstruct(code)
        found = code.(strrep(stage, '-', '_'))(given);
      else
        found = code(stage, given);
      end
      if isempty(found), continue; end
      [digits, why] = agreement(found, golden, times);
    catch fault
      [digits, why] = deal(0, fault.message);
    end
    compared = compared + 1;
    failed = failed + ~isempty(why);
    if isempty(why), word = 'pass'; else, word = ['FAIL  ' why]; end
    fprintf('%-40s %5.1f  %s\n', cells{1}, digits, word);
  end
  if compared == 0, error('nothing was compared: no stage of the pack is offered'); end
  fprintf('%d of %d vectors pass; %d are of stages that were not offered.\n', compared - failed, compared, ...
          numel(lines) - 2 - compared);
end

function [given, golden] = both(cells, folder, form)  % what a vector gives, and what is right
  rest = cells(7:end);
  right = strncmp(rest, 'golden_', 7);
  given = arrays(parameters(rest(~right)), folder, form, cells{3}, str2double(cells{4}));
  golden = arrays(parameters(strrep(rest(right), 'golden_shape_', 'shape_')), folder, form, cells{5}, str2double(cells{6}));
  given.id = cells{1};
end

function [digits, why] = agreement(found, golden, times)  % the fewest digits of all outputs, and what fell short
  names = fieldnames(golden);
  names = names(strncmp(names, 'allowed_', 8));
  if ~isstruct(found)
    if numel(names) > 1, error('this stage has %d outputs: return a structure of them', numel(names)); end
    found = struct(strrep(names{1}, 'allowed_', ''), found);
  end
  [digits, why] = deal(15.6, '');
  for n = 1:numel(names)
    name = strrep(names{n}, 'allowed_', '');
    shape = golden.(['shape_' name]);
    if ~isfield(found, name), error('%s is missing', name); end
    mine = found.(name);
    sizes = [size(mine), ones(1, numel(shape) - ndims(mine))];
    if numel(mine) ~= prod(shape) || (numel(shape) > 1 && ~isequal(sizes(1:numel(shape)), shape))
      error('%s has shape %s, should be %s', name, mat2str(size(mine)), mat2str(shape));
    end
    [mine, right, allowed] = deal(double(mine(:)), golden.(name)(:), golden.(names{n})(:));
    off = abs(mine - right);
    good = off <= times * allowed | (isnan(mine) & isnan(right));
    scale = max(abs(right));
    if any(~good)
      [~, worst] = max(off .* ~good + ~isfinite(off) .* ~good * realmax);
      why = sprintf('%s %s(%d) is %.16g, should be %.16g within %.2g', why, name, worst, mine(worst), right(worst), ...
                    times * allowed(worst));
    end
    largest = max(off);
    if scale > 0 && largest > 0, digits = min(digits, max(0, floor(-10 * log10(largest / scale)) / 10)); end
    if any(~good & ~isfinite(off)), digits = 0; end
  end
  why = strtrim(why);
end

@SHARED@
