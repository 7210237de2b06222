. /work/wt/scans.env
cd /work/wt/tmp-scans/ten
for s in 11 12 13 14 15; do
f=$(ls h${s}_neutral.*)
/usr/bin/env time -f "%U user %e wall %M kB" nice -n 5 python -m elastomorph register $f ${f/neutral/pose} --template built-in --no-texture -o out-plain > log-$s.txt 2>&1
done
