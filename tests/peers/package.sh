#!/usr/bin/env bash
# Installs, upgrades, removes and purges the Debian package on an emulated computer that is booted by systemd: package.sh PROGRAM
# Its service reads a serial port there under all restrictions of its unit, is killed and comes back. Exit status: that of the trial inside.
# Needs: qemu-system-x86 debootstrap cpio binutils python3, and the download of a kernel and of a minimal Debian. Made files:
# target/package-machine. With TRUNNION_WRITE_DOCS it writes docs/measured/package.md.
set -euo pipefail
program=$(readlink -f "$1")
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$here/target/package-machine
mkdir -p "$work"
cd "$work"
exec 9>lock
flock 9

# No more than the unit promises: tenths of systemd's measure.
exposure=$(systemd-analyze security --offline=true "$here/systemd/trunnion.service" | sed -n 's/.*exposure level.*: \([0-9.]*\) .*/\1/p')
echo "exposure $exposure"
awk -v found="$exposure" 'BEGIN { exit !(found != "" && found <= 1.5) }'

. "$here/tests/peers/kernel.sh"
if ! [ -d debian/etc ]; then
  rm -rf debian.partial
  debootstrap --variant=minbase --include=systemd,systemd-sysv,udev bookworm debian.partial >debootstrap.log
  rm -rf debian.partial/usr/share/{doc,locale,man,zoneinfo} debian.partial/var/{cache,lib}/apt debian.partial/usr/lib/x86_64-linux-gnu/gconv
  mv debian.partial debian
fi

rm -rf root packages root.cpio
cp -a debian root
mkdir -p packages root/trial
first=$("$here/systemd/deb/build" "$program" packages 1.0.0)
second=$("$here/systemd/deb/build" "$program" packages 1.0.1)
cp "$first" root/trial/first.deb
cp "$second" root/trial/second.deb
cp "$here/tests/peers/package_trial.sh" root/trial/run
data=$here/tests/data/points-gravity
# Every fourth point: all of them take more than five minutes on the emulated processor.
awk 'NR == 1 || NR % 4 == 2' "$data/points.csv" >packages/points.csv
"$program" import packages/points.csv --setup "$data/setup.toml" -o root/trial/run.mcap
cat >root/etc/systemd/system/trial.service <<'END'
[Unit]
Wants=multi-user.target
After=multi-user.target
[Service]
Type=oneshot
StandardOutput=tty
TTYPath=/dev/ttyS0
ExecStart=/bin/bash /trial/run
ExecStopPost=/bin/systemctl --force --force poweroff
END
ln -sf /etc/systemd/system/trial.service root/etc/systemd/system/default.target
# The trial writes to the first serial line.
ln -sf /dev/null root/etc/systemd/system/serial-getty@ttyS0.service
ln -sf /sbin/init root/init
(cd root && find . -xdev | cpio -o -H newc --quiet) >root.cpio

# The second serial line is the port of a probe that says nothing.
timeout 900 qemu-system-x86_64 -M q35 -accel tcg -m 1536 -smp 1 -nographic -no-reboot -nodefaults \
  -serial stdio -serial null -kernel vmlinux -initrd root.cpio \
  -append "console=ttyS0 quiet panic=-1 mitigations=off systemd.unit=trial.service" </dev/null 2>&1 | tr -d '\r' | tee last.log
status=$(sed -n 's/^.*STATUS=//p' last.log | tail -1)
if [ -n "${TRUNNION_WRITE_DOCS:-}" ] && [ "$status" = 0 ]; then
  {
    cat <<'END'
# The package on a clean Debian

Written by `TRUNNION_WRITE_DOCS=1 tests/peers/run --package`. A minimal Debian 12, booted by systemd on an emulated computer (one processor, in software, many times slower than a real one), gets the package, the
example configuration with its first probe on a serial port that says nothing, and a recording of 84 poses. Every step has to succeed, or the run fails and this page stays as it was.

END
    echo "Exposure of the unit by \`systemd-analyze security\`: $exposure."
    echo
    echo "| step | command | time |"
    echo "|---|---|---:|"
    sed -n 's/^.*passed: \(.*\) | \(.*\) | \(.*\)$/| \1 | \2 | \3 |/p' last.log
  } >"$here/docs/measured/package.md"
fi
exit "${status:-125}"
