% An adapter in GNU Octave (7 or later): put your own code in place of what extract does here.
% It speaks protocol 1: a line of JSON in, a line of JSON out, arrays in mat files.
1;

function said = ready()  % what the code expects and returns; leakref converts to it and back
  said = ['{"op": "ready", "protocol": 1, "name": "my code", "version": "1", "format": "mat", "units": "si", ' ...
          '"axes": "xyt", "y": "up", "direction": "to", "water": {"depth": "given"}, ' ...
          '"can": {"window": {"names": ["box", "hann"]}, ' ...
          '"extract": {"methods": ["ls"], "windows": ["box", "hann"], "resolves": "wavenumber"}}}'];
end

function w = taper(name, n)
  w = ones(n, 1);
  if strcmp(name, "hann")
    w = 0.5 - 0.5 * cos(2 * pi * (0:n-1)' / n);
  end
end

function k = bins(n, step)  % angular wavenumbers or frequencies in the order of fft
  k = 2 * pi / (n * step) * [0:ceil(n / 2) - 1, -floor(n / 2):-1];
end

% The current (cx, cy) that the waves near each wavenumber see, a row each, NaN where there is none to give: a fit of
% omega = sqrt(g k tanh(k h)) + k.c by least squares to the strong bins around each. eta is (x, y, t), h p.depth.
function c = extract(eta, p)
  [nx, ny, nt] = size(eta);
  eta = eta .* taper(p.window, nx) .* taper(p.window, ny)' .* reshape(taper(p.window, nt), 1, 1, nt);
  power = abs(fftn(eta)) .^ 2;
  half = floor(nt / 2) + 1;
  power = reshape(power(:, :, 1:half), nx * ny, half);
  omega = 2 * pi / (nt * p.dt) * (0:half - 1);
  % fftn transforms forwards in time too, which puts a wave that goes along k at -k
  [kx, ky] = ndgrid(-bins(nx, p.dx), -bins(ny, p.dy));
  k = hypot(kx, ky);
  width = 2 * pi / min(nx * p.dx, ny * p.dy);
  nyquist = pi / max(p.dx, p.dy);
  c = nan(numel(p.wavenumbers), 2);
  for n = 1:numel(p.wavenumbers)
    shell = find(abs(k(:) - p.wavenumbers(n)) <= 2.000001 * width);
    largest = max(max(power(shell, :)));
    if p.wavenumbers(n) + 2 * width >= nyquist || isempty(largest) || largest == 0
      continue
    end
    [i, m] = find(power(shell, :) >= 0.2 * largest);
    strong = shell(i(:));
    direction = [kx(strong), ky(strong)];
    shift = reshape(omega(m), [], 1) - sqrt(p.gravity * k(strong) .* tanh(p.depth * k(strong)));
    normal = direction' * direction;
    known = eig(normal);
    if min(known) > 1e-9 * max(known)  % waves in one direction say nothing of the current across it
      c(n, :) = (normal \ (direction' * shift))';
    end
  end
end

function said = answer(request)
  p = request.parameters;
  extra = "";
  if strcmp(request.stage, "window")
    w = taper(p.name, p.size);
    save("-v6", request.output, "w");  % a mat file of version 5
  else
    data = load(request.input);
    if ! all(isfinite(data.eta(:)))
      error("the surface holds values that are not finite");
    end
    c = extract(data.eta, p);
    pairs = cell(1, rows(c));
    for n = 1:numel(pairs)
      pairs{n} = "null";
      if all(isfinite(c(n, :)))
        pairs{n} = sprintf("[%.17g, %.17g]", c(n, :));
      end
    end
    extra = [', "velocities": [', strjoin(pairs, ", "), "]"];
  end
  said = sprintf('{"id": %d, "status": "ok"%s}', request.id, extra);
end

while true
  request = jsondecode(input("", "s"));  % fgetl would wait for the line after this one
  switch request.op
    case "start"
      said = ready();
    case "run"
      try
        said = answer(request);
      catch fault
        said = jsonencode(struct("id", request.id, "status", "error", "message", fault.message));
      end
    otherwise
      break
  end
  puts([said, "\n"]);
  fflush(stdout);
end
