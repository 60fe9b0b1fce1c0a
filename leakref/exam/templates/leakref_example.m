function leakref_example()
% A small least-squares fit that answers the examination in this folder: put your own code in the place of extract.
  leakref_exam(struct('extract', @deep_or_not, 'window', @(p) taper(p.name, p.size)));
end

function c = deep_or_not(eta, p)
  if ~isfield(p, 'depth'), p.depth = Inf; end
  if ~all(isfinite(eta(:))), error('the surface holds values that are not finite'); end
  c = extract(eta, p);
end

@FIT@
