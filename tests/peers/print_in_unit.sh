#!/usr/bin/env bash
# Prints a report with the browser of this computer under all restrictions of the unit: print_in_unit.sh PROGRAM
# systemd itself sets them up, as the first process of namespaces of its own. Exit status: 0 where the PDF was printed.
# Needs: root, systemd, a kernel with cgroup2 and overlayfs, a Chromium or Chrome. Made files: target/print-in-unit.
set -euo pipefail
if [ "${1:-}" != inside ]; then
  program=$(readlink -f "$1")
  here=$(cd "$(dirname "$0")/../.." && pwd)
  work=$here/target/print-in-unit
  rm -rf "$work"
  mkdir -p "$work/units" "$work/layers"
  data=$here/tests/data/points-gravity
  "$program" import "$data/points.csv" --setup "$data/setup.toml" -o "$work/run.mcap" >/dev/null
  cp "$program" "$work/trunnion"
  cat >"$work/print" <<'END'
#!/bin/sh
set -e
cp /opt/run.mcap run.mcap
/opt/trunnion report run.mcap --pdf report.pdf
ls -A
head -c 5 report.pdf
END
  chmod 755 "$work/print"
  cat >"$work/units/trial.target" <<'END'
[Unit]
DefaultDependencies=no
Wants=print.service
END
  # What says how the service is started and watched is no restriction; sysusers.conf makes its user, whose groups are not needed here.
  {
    printf '[Unit]\nDefaultDependencies=no\nSuccessAction=exit-force\nFailureAction=exit-force\n'
    sed -n '/^\[Service\]/,/^\[Install\]/p' "$here/systemd/trunnion.service" |
      grep -Ev '^(#|\[Install\]|(Type|ExecStart|Restart|RestartSec|WatchdogSec|SupplementaryGroups)=)'
    printf 'Type=oneshot\nExecStart=/opt/print\nTimeoutStartSec=120\n'
    printf 'StandardOutput=file:%s\nStandardError=file:%s\n' "$work/said" "$work/errors"
  } >"$work/units/print.service"
  group=/sys/fs/cgroup
  [ -d $group/unified ] && group=$group/unified
  mkdir -p "$group/print-in-unit"
  (
    echo "$BASHPID" >"$group/print-in-unit/cgroup.procs"
    exec timeout -k 10 180 unshare --mount --pid --fork --kill-child --mount-proc --net --uts --ipc --cgroup "$0" inside "$work"
  ) >"$work/systemd.log" 2>&1 || true
  find "$group/print-in-unit" -depth -type d -exec rmdir {} + || true
  cat "$work/said" "$work/errors"
  [ "$(tail -c 5 "$work/said")" = "%PDF-" ]
  exit
fi

work=$2
mount --make-rprivate /
# Nothing of this computer is changed: what is written there goes into memory.
mount -t tmpfs none "$work/layers"
for folder in etc var; do
  mkdir -p "$work/layers/$folder" "$work/layers/$folder.work"
  mount -t overlay none -o "lowerdir=/$folder,upperdir=$work/layers/$folder,workdir=$work/layers/$folder.work" "/$folder"
done
getent passwd trunnion >/dev/null || useradd --system --user-group --home-dir /var/lib/trunnion trunnion
systemd-id128 new >/etc/machine-id
umount -l /sys/fs/cgroup/* /sys/fs/cgroup 2>/dev/null || true
mount -t cgroup2 none /sys/fs/cgroup
mount -t tmpfs none /run
mkdir -p /run/systemd/system
cp "$work"/units/* /run/systemd/system/
mount -t tmpfs none /opt
cp "$work/trunnion" "$work/print" "$work/run.mcap" /opt
mount --bind /proc/sys /proc/sys
mount -o remount,bind,ro /proc/sys
exec env -i container=trial PATH=/usr/bin:/bin:/usr/sbin:/sbin /lib/systemd/systemd --system --unit=trial.target --log-target=console
