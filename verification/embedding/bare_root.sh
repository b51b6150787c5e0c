#!/usr/bin/env bash
# From `pip install` to a picture in a bare Debian: no compiler, no library, nothing of this tree but a wheel of
# tools/wheel and a deck. Needs root, debootstrap and the network: verification/embedding/bare_root.sh WHEEL [FOLDER]
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
wheel=$(realpath "$1")
root=${2:-/tmp/qsmpm-bare}
if [ ! -x "$root/usr/bin/python3" ]; then
  debootstrap --variant=minbase --include=python3,python3-pip,python3-venv,ca-certificates bookworm "$root" \
    http://deb.debian.org/debian >/dev/null
fi
cp -L /etc/resolv.conf "$root/etc/resolv.conf"
# Certificates and settings of pip of this computer: it may reach the registry through a proxy.
cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/ca-certificates.crt"
mountpoint -q "$root/dev" || mount --bind /dev "$root/dev"
mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
trap 'umount "$root/dev" "$root/proc"' EXIT
rm -rf "$root/root/try"
mkdir "$root/root/try"
cp "$wheel" "$top/input/slope_safety.inp" "$root/root/try/"
cat > "$root/root/try/steps.sh" <<'STEPS'
set -eu
cd /root/try
for program in gcc gfortran cmake; do ! command -v $program || { echo "$program is there: this root is not bare"; exit 1; }; done
python3 -m venv environment
begin=$SECONDS
environment/bin/pip install --quiet "$(ls "$PWD"/*.whl)[verify]"
echo "pip install: $((SECONDS - begin)) s"
begin=$SECONDS
environment/bin/qsmpm run slope_safety.inp --out run --quiet
echo "qsmpm run slope_safety.inp: $((SECONDS - begin)) s"
begin=$SECONDS
environment/bin/qsmpm-verify view run --out slope.png
test -s slope.png
echo "qsmpm-verify view: $((SECONDS - begin)) s"
STEPS
chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root $(env | grep -E '^(PIP_INDEX|PIP_CERT|https?_proxy|HTTPS?_PROXY)' || true) \
  OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 bash /root/try/steps.sh
