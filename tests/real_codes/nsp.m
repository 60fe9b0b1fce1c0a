% Near-surface currents by the normalized scalar product, as one writes it for oneself in Octave (7 or later) with
% fminsearch, behind protocol 1.
1;

% |S| of a cube eta(x, y, t) at frequencies >= 0, a row for each (kx, ky), and what each row and column is.
function s = transformed(eta, p)
  s.domain = size(eta) .* [p.dx, p.dy, p.dt];
  for axis = 1:3
    n = size(eta, axis);
    if strcmp(p.window, "hann")
      eta = eta .* reshape(sin(pi * (0:n-1) / n) .^ 2, circshift([n 1 1], axis - 1));
    end
  end
  n = size(eta);
  half = 1 + floor(n(3) / 2);
  S = ifft(fft(fft(eta, [], 1), [], 2), [], 3);  % exp(-i (k.x - omega t)): a wave is at its own k
  s.F = reshape(abs(S(:, :, 1:half)), [], half);
  numbers = @(m) mod((0:m-1) + floor(m / 2), m) - floor(m / 2);
  [kx, ky] = ndgrid(2 * pi / s.domain(1) * numbers(n(1)), 2 * pi / s.domain(2) * numbers(n(2)));
  s.k = [kx(:), ky(:)];
  s.omega = 2 * pi / s.domain(3) * (0:half-1);
  s.weight = ones(1, half);  % the other half of the space is the mirror image of this one
  s.weight([1, half(2 * half - 2 == n(3))]) = 0.5;
  s.nyquist = pi / max(p.dx, p.dy);
end

function N = overlap(F, k, omega0, omega, weight, a, c)
  shift = k * c(:);
  G = exp(-2 * ((omega - omega0 - shift) / a) .^ 2) + exp(-2 * ((omega + omega0 - shift) / a) .^ 2);
  G = G .* weight;
  N = sum(sum(F .* G)) / (sum(G(:)) + realmin) / sum(F * weight');
end

% The current (cx, cy) near one wavenumber; NaN where there is nothing to see.
function c = current(s, wavenumber, gravity)
  dk = 2 * pi / min(s.domain(1:2));
  size_k = hypot(s.k(:, 1), s.k(:, 2));
  in = find(abs(size_k - wavenumber) < 2 * dk * (1 + 1e-9));
  c = [NaN, NaN];
  if wavenumber + 2 * dk < s.nyquist && any(any(s.F(in, :) > 1e-12 * max(s.F(:))))
    a = 4 * 2 * pi / s.domain(3);
    step = 0.01 * sqrt(gravity / wavenumber);  % the first simplex of fminsearch has sides of 1: as long as this
    objective = @(c) -overlap(s.F(in, :), s.k(in, :), sqrt(gravity * size_k(in)), s.omega, s.weight, a, c);
    scale = -objective([0 0]);
    c = step * fminsearch(@(c) objective(step * c) / scale, [0 0], optimset("TolX", 1e-7, "TolFun", 1e-12));
  end
end

function text = velocities(request)
  p = request.parameters;
  data = load(request.input);
  if ! all(isfinite(data.eta(:)))
    error("there are gaps in the surface");
  end
  s = transformed(data.eta, p);
  rows = arrayfun(@(k) sprintf("[%.15g, %.15g]", current(s, k, p.gravity)), p.wavenumbers(:)', "UniformOutput", false);
  text = strrep(strjoin(rows, ", "), "[NaN, NaN]", "null");
end

ready = ['{"op": "ready", "protocol": 1, "name": "nsp.m", "version": "1", "format": "mat", "units": "si", ' ...
         '"axes": "xyt", "y": "up", "direction": "to", "can": {"extract": {"methods": ["nsp"], ' ...
         '"windows": ["box", "hann"], "resolves": "wavenumber"}}}'];
while true
  request = jsondecode(input("", "s"));
  if strcmp(request.op, "stop")
    break
  elseif strcmp(request.op, "start")
    said = ready;
  else
    try
      said = sprintf('{"id": %d, "status": "ok", "velocities": [%s]}', request.id, velocities(request));
    catch fault
      said = jsonencode(struct("id", request.id, "status", "error", "message", fault.message));
    end
  end
  puts([said, "\n"]);
  fflush(stdout);
end
