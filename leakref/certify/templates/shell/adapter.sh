#!/bin/sh
# An adapter in POSIX sh, sed, awk and od: any program that reads and writes plain files of numbers can take part.
# It speaks protocol 1: a line of JSON in, a line of JSON out. In the format raw an array is a file NAME.f64 of
# little-endian float64 in C order. Put your own program in place of the awk programs here.
LC_ALL=C
export LC_ALL

# The value of a key: $1 the line, $2 the key. Enough for what leakref sends, if no path has quotation marks in it.
text() { printf '%s\n' "$1" | sed -n 's/.*"'"$2"'": *"\([^"]*\)".*/\1/p'; }
number() { printf '%s\n' "$1" | sed -n 's/.*"'"$2"'": *\([-+.0-9eE]*\).*/\1/p'; }
numbers() { printf '%s\n' "$1" | sed -n 's/.*"'"$2"'": *\[\([^]]*\)\].*/\1/p' | tr -d ','; }

# What both awk programs need: a taper, and a number as the eight bytes of a float64, in octal for printf.
shared='
function taper(name, n, size) { return name == "hann" ? 0.5 - 0.5 * cos(2 * pi * n / size) : 1 }
function bytes(v,    sign, e, b, n, octal) {
  sign = v < 0 ? 128 : 0; if (v < 0) v = -v
  if (v < 1e-300) return "\\000\\000\\000\\000\\000\\000\\000\\000"
  for (e = 1023; v >= 2; e++) v /= 2
  for (; v < 1; e--) v *= 2
  v = (v - 1) * 4503599627370496
  for (n = 0; n < 6; n++) { b = v % 256; v = (v - b) / 256; octal = octal sprintf("\\%03o", b) }
  return octal sprintf("\\%03o\\%03o", e % 16 * 16 + v, sign + int(e / 16))
}
BEGIN { pi = atan2(0, -1); n = 0 }'

window='BEGIN { for (n = 0; n < size; n++) print bytes(taper(name, n, size)) }'

# S = sum of w eta exp(-i (k.x - omega t)): the plain sum along one axis after the other, of the numbers that od prints.
spectrum='
{ for (f = 1; f <= NF; f++) {
    if ($f !~ /^[-+.0-9e]+$/) exit 1  # not finite
    t = n % nt; y = (n - t) / nt % ny; x = int(n / (nt * ny))
    re[n] = $f * taper(name, x, nx) * taper(name, y, ny) * taper(name, t, nt); im[n++] = 0
} }
function transform(size, stride, sign,    base, m, j, a, b, at) {
  for (m = 0; m < size; m++) { c[m] = cos(2 * pi * m / size); s[m] = sign * sin(2 * pi * m / size) }
  for (base = 0; base < n; base++) {
    if (int(base / stride) % size) continue
    for (j = 0; j < size; j++) { u[j] = re[base + j * stride]; v[j] = im[base + j * stride] }
    for (m = 0; m < size; m++) {
      a = b = at = 0
      for (j = 0; j < size; j++) {
        a += u[j] * c[at] - v[j] * s[at]; b += u[j] * s[at] + v[j] * c[at]; at = (at + m) % size
      }
      re[base + m * stride] = a; im[base + m * stride] = b
    } } }
END {
  if (n != nx * ny * nt) exit 1
  transform(nt, 1, 1); transform(ny, nt, -1); transform(nx, ny * nt, -1)
  for (m = 0; m < n; m++) print bytes(re[m]) bytes(im[m])
}'

write() { while read -r octal; do printf "$octal"; done >"$1"; }

while read -r line; do
  id=$(number "$line" id)
  case $(text "$line" op)-$(text "$line" stage) in
  start-*)
    echo '{"op": "ready", "protocol": 1, "name": "my tool", "version": "1", "format": "raw", "can":' \
      '{"window": {"names": ["box", "hann"]}, "spectrum": {"windows": ["box", "hann"]}}}' ;;
  run-window)
    awk -v name="$(text "$line" name)" -v size="$(number "$line" size)" "$shared $window" </dev/null |
      write "$(text "$line" output)/w.f64"
    echo "{\"id\": $id, \"status\": \"ok\"}" ;;
  run-spectrum)
    set -- $(numbers "$line" eta)
    if octal=$(od -A n -v -t f8 "$(text "$line" input)/eta.f64" |
      awk -v name="$(text "$line" window)" -v nx="$1" -v ny="$2" -v nt="$3" "$shared $spectrum"); then
      printf '%s\n' "$octal" | write "$(text "$line" output)/S.f64"
      echo "{\"id\": $id, \"status\": \"ok\"}"
    else
      echo "{\"id\": $id, \"status\": \"error\", \"message\": \"eta is not as it should be\"}"
    fi ;;
  run-*) echo "{\"id\": $id, \"status\": \"unsupported\", \"message\": \"this tool has no such stage\"}" ;;
  *) exit 0 ;;
  esac
done
