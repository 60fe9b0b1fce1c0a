function leakref_exam(code, folder)
% LEAKREF_EXAM  Answers the questions in this folder with a function of yours (MATLAB R2016b, Octave 6, or later).
%
%   leakref_exam(@my_current)
%
% where c = my_current(eta, p) gives a row (cx, cy) for each of p.wavenumbers, NaN where it has no number. eta is the
% cube, p has dx, dy, dt, gravity, wavenumbers, window, method (and depth, surface_tension if you declared them), and
% x, y, t. A code with wavenumbers of its own returns a struct with velocities and wavenumbers. For other stages:
%
%   leakref_exam(struct('extract', @my_current, 'window', @my_window, 'spectrum', @my_spectrum, ...
%                       'synthesize', @my_surface))
%
% with w = my_window(p), of p.name and p.size; S = my_spectrum(eta, p); eta = my_surface(p), of p.kx, p.ky, p.omega,
% p.amplitude, p.phase, p.x, p.y, p.t. What a function cannot do it says by error('leakref:unsupported', 'why').
% Stopped, it goes on where it was; to start anew remove answers.part.
  if nargin < 2, folder = fileparts(mfilename('fullpath')); end
  if ~isstruct(code), code = struct('extract', code); end
  tab = sprintf('\t');
  lines = strsplit(strtrim(fileread(fullfile(folder, 'questions.tsv'))), sprintf('\n'));
  head = strsplit(lines{1}, tab);
  [digest, form] = head{2:3};
  if ~strcmp(head{1}, 'leakref/exam/1') || ~any(strcmp(form, {'raw', 'mat'}))
    error('questions.tsv is no examination in raw or mat: have it written with --format raw or mat');
  end
  declared = strtrim(fileread(fullfile(folder, 'declaration.json')));
  [done, answers] = kept(folder, digest);
  count = numel(lines) - 2;
  begun = tic;
  asked = 0;
  for n = 1:count
    cells = strsplit(lines{n + 2}, tab);
    if any(strcmp(cells{1}, done)), continue; end
    started = tic;
    answers{end + 1} = answered(code, folder, form, cells); %#ok<AGROW>
    keep(folder, digest, declared, cells{1}, answers);
    asked = asked + 1;
    left = toc(begun) / asked * (count - numel(answers));
    fprintf('%4d of %d  %-44s %6.2f s, about %.0f s to go\n', n, count, cells{1}, toc(started), left);
  end
  keep(folder, digest, declared, '', answers);
  fprintf('All %d questions are answered, in answers.json. For the marks, where leakref is installed:\n\n', count);
  fprintf('    leakref exam grade %s\n\n', folder);
end

function [done, answers] = kept(folder, digest)  % what was answered before: a line each, the id and the answer
  done = {}; answers = {};
  path = fullfile(folder, 'answers.part');
  if exist(path, 'file') ~= 2
    if exist(fullfile(folder, 'answers.json'), 'file') == 2
      error('there is an answers.json that no answers.part goes with: move it away');
    end
    put(path, 'w', [digest sprintf('\n')]);
    return
  end
  text = fileread(path);
  whole = find(text == sprintf('\n'), 1, 'last');  % a line that was cut off is answered again
  lines = strsplit(text(1:whole - 1), sprintf('\n'));
  if isempty(whole) || ~strcmp(lines{1}, digest)
    error('answers.part answers another examination: remove it, and answers.json, to answer this one');
  end
  put(path, 'w', text(1:whole));
  for n = 2:numel(lines)
    at = find(lines{n} == sprintf('\t'), 1);
    done{end + 1} = lines{n}(1:at - 1); %#ok<AGROW>
    answers{end + 1} = lines{n}(at + 1:end); %#ok<AGROW>
  end
end

function keep(folder, digest, declared, id, answers)  % after each question: answers.json is whole at any time
  if ~isempty(id)
    put(fullfile(folder, 'answers.part'), 'a', [id sprintf('\t') answers{end} sprintf('\n')]);
  end
  new = fullfile(folder, 'answers.new');
  put(new, 'w', sprintf('{"digest": "%s", "code": %s, "answers": [\n%s\n]}\n', digest, declared, ...
                        strjoin(answers, sprintf(',\n'))));
  if exist('OCTAVE_VERSION', 'builtin')
    rename(new, fullfile(folder, 'answers.json'));
  else
    movefile(new, fullfile(folder, 'answers.json'), 'f');
  end
end

function put(path, mode, text)
  file = fopen(path, mode);
  if file < 0, error('%s cannot be written', path); end
  fwrite(file, text, 'char');
  fclose(file);
end

function text = answered(code, folder, form, cells)  % one question: its answer as JSON
  [id, stage, input] = cells{1:3};
  rest = '';
  try
    p = parameters(cells(6:end));
    p = arrays(p, folder, form, input, str2double(cells{4}));
    if ~isfield(code, stage)
      error('leakref:unsupported', 'no function was given for %s', stage);
    end
    switch stage
      case 'extract'
        rest = velocities(code.extract(p.eta, rmfield(p, 'eta')));
      case 'spectrum'
        rest = output(folder, form, cells{5}, 'S', code.spectrum(p.eta, rmfield(p, 'eta')));
      case 'synthesize'
        rest = output(folder, form, cells{5}, 'eta', code.synthesize(p));
      case 'window'
        rest = output(folder, form, cells{5}, 'w', code.window(p));
      otherwise
        error('leakref:unsupported', 'this runner knows no stage %s', stage);
    end
    status = 'ok';
  catch fault
    if strcmp(fault.identifier, 'leakref:stale'), rethrow(fault); end
    status = 'error';
    if strcmp(fault.identifier, 'leakref:unsupported'), status = 'unsupported'; end
    message = fault.message;
    message(message < 32 | message > 126 | message == '"' | message == '\') = ' ';
    rest = [', "message": "' message '"'];
  end
  text = sprintf('{"id": "%s", "status": "%s"%s}', id, status, rest);
end

function p = parameters(cells)  % NAME=VALUE: words, numbers, or several with commas between them
  p = struct();
  for n = 1:numel(cells)
    at = find(cells{n} == '=', 1);
    [name, value] = deal(cells{n}(1:at - 1), cells{n}(at + 1:end));
    if ~any(strcmp(name, {'window', 'method', 'name'}))
      value = str2double(strsplit(value, ','));
    end
    p.(name) = value;
  end
end

function p = arrays(p, folder, form, input, should)  % with the arrays of the question; refuses another's input
  names = fieldnames(p);
  names = sort(strrep(names(strncmp(names, 'shape_', 6)), 'shape_', ''));
  if strcmp(input, '-'), return; end
  path = fullfile(folder, input);
  bytes = zeros(0, 1, 'uint8');
  if strcmp(form, 'mat')
    bytes = octets(path);
    held = load(path);
  end
  for n = 1:numel(names)
    shape = p.(['shape_' names{n}]);
    if strcmp(form, 'mat')
      if isfield(held, names{n}), p.(names{n}) = held.(names{n}); end
    elseif exist(fullfile(path, [names{n} '.f64']), 'file') == 2
      own = octets(fullfile(path, [names{n} '.f64']));
      bytes = [bytes; own]; %#ok<AGROW>
      values = typecast(own, 'double');  % little-endian, the last index fastest
      if numel(shape) > 1
        values = permute(reshape(values, fliplr(shape)), numel(shape):-1:1);
      end
      p.(names{n}) = values;
    end
    if isfield(p, names{n}) && numel(shape) == 1, p.(names{n}) = p.(names{n})(:)'; end
  end
  if adler(bytes) ~= should
    error('leakref:stale', '%s is not the input of this examination: copy the whole folder again', input);
  end
end

function bytes = octets(path)
  file = fopen(path, 'r');
  if file < 0, error('leakref:stale', '%s is not there: copy the whole folder again', path); end
  bytes = fread(file, Inf, '*uint8');
  fclose(file);
end

function sum32 = adler(bytes)  % Adler-32
  b = double(bytes(:));
  n = numel(b);
  sum32 = mod(n + sum(mod((n:-1:1)', 65521) .* b), 65521) * 65536 + mod(1 + sum(b), 65521);
end

function rest = velocities(c)
  rest = '';
  if isstruct(c)
    rest = sprintf(', "wavenumbers": [%s]', strjoin(arrayfun(@number, c.wavenumbers(:)', 'UniformOutput', false), ', '));
    c = c.velocities;
  end
  rows = cell(1, size(c, 1));
  for n = 1:numel(rows)
    rows{n} = 'null';
    if ~any(isnan(c(n, :)))
      rows{n} = ['[' strjoin(arrayfun(@number, c(n, :), 'UniformOutput', false), ', ') ']'];
    end
  end
  rest = [rest ', "velocities": [' strjoin(rows, ', ') ']'];
end

function text = number(value)
  text = sprintf('%.17g', value);
  if isinf(value), text = strrep(strrep(lower(text), 'inf', '1e999'), '+', ''); end  % JSON has no word for it
end

function rest = output(folder, form, place, name, value)  % an array that comes back, as a file
  path = fullfile(folder, place);
  if strcmp(form, 'mat')
    if exist(fileparts(path), 'dir') ~= 7, mkdir(fileparts(path)); end
    held = struct(name, value); %#ok<NASGU>
    save(path, '-struct', 'held', '-v6');
  else
    if exist(path, 'dir') ~= 7, mkdir(path); end
    value = permute(value, ndims(value):-1:1);
    value = value(:).';
    if ~isreal(value), value = [real(value); imag(value)]; end
    file = fopen(fullfile(path, [name '.f64']), 'w', 'ieee-le');
    fwrite(file, value, 'double');
    fclose(file);
  end
  rest = sprintf(', "output": "%s"', place);
end
