#!/bin/sh
# A wheel in an empty environment, read-only, run by a user without a home: twice, then looked at by codend doctor.
# To be run by root from the root of the repository; PYTHON is one that every user may run.
set -eu
python=${PYTHON:-/usr/bin/python3}
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
chmod 755 "$place"
"$python" -m venv "$place/env"
"$place/env/bin/pip" install -q .
chmod -R a+rX,a-w "$place/env"
install -d -m 777 "$place/work"
install -m 644 validation/cases/flume_150x140.toml "$place/work/plan.toml"
cd "$place/work"
nobody="setpriv --reuid=65534 --regid=65534 --clear-groups env -i PATH=/usr/bin:/bin"
for time in first second; do
    echo "== the $time run"
    $nobody "$place/env/bin/codend" run plan.toml --set "catch.filled_meshes=[10, 20]" --out out
done
echo "== doctor"
$nobody "$place/env/bin/codend" doctor
echo "== from Python"
$nobody "$place/env/bin/python" -c "
import codend
print(codend.solve(codend.load_plan('plan.toml', ['catch.filled_meshes=[10, 20]'])).table['drag_n'].tolist())"
