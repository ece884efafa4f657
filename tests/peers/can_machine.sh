#!/usr/bin/env bash
# Runs a program on an emulated computer whose kernel has SocketCAN: can_machine.sh MODE PROGRAM
#   vcan    vcan0, a bus without hardware
#   kvaser  can0 and can1, two emulated Kvaser PCIcan cards on one bus of 1 Mbit/s
#   slcan   sl0, the kernel's own slcan driver on a serial line that the terminal named in $PEER_TTY ends
# The program gets the mode as its argument; its exit status is that of this script. Debian's generic kernel boots from an
# initramfs made here. Made files: target/can-machine.
# Needs: qemu-system-x86 busybox-static cpio iproute2 can-utils xz-utils binutils python3, and the download of a kernel.
set -euo pipefail
mode=$1 program=$(readlink -f "$2")
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$here/target/can-machine
mkdir -p "$work"
cd "$work"
# One computer at a time: they share the kernel, and the processors of this one.
exec 9>lock
flock 9

. "$here/tests/peers/kernel.sh"
version=${vmlinuz##*vmlinuz-}
drivers=kernel/lib/modules/$version/kernel

root=root-$mode
rm -rf "$root"
mkdir -p "$root"/{bin,full,proc,sys,dev,tmp,mod}
cp /bin/busybox "$root/bin/"
with_libraries() { # FILE FOLDER NAME
  cp -L "$1" "$root/$2/$3"
  ldd "$1" | grep -o '/[^ ]*' | while read -r library; do
    mkdir -p "$root$(dirname "$library")"
    cp -Ln "$library" "$root$library" 2>/dev/null || true
  done
}
strip -o "$root/bin/trial" "$program"
with_libraries "$program" tmp libraries-only
rm "$root/tmp/libraries-only"
# The ip of busybox knows no CAN, and its shell prefers its own.
with_libraries "$(command -v ip || echo /sbin/ip)" full ip
[ "$mode" != slcan ] || with_libraries "$(command -v slcand)" bin slcand
modules="net/can/can net/can/can-raw drivers/net/can/dev/can-dev"
case $mode in
  vcan) modules+=" drivers/net/can/vcan" ;;
  kvaser) modules+=" drivers/net/can/sja1000/sja1000 drivers/net/can/sja1000/kvaser_pci" ;;
  slcan) modules+=" drivers/net/can/slcan/slcan" ;;
  *) echo "there is no mode $mode; allowed: vcan, kvaser, slcan" >&2; exit 2 ;;
esac
load=""
for module in $modules; do
  name=$(basename "$module")
  if [ -f "$drivers/$module.ko" ]; then cp "$drivers/$module.ko" "$root/mod/"; else xz -dc "$drivers/$module.ko.xz" >"$root/mod/$name.ko"; fi
  load+="insmod /mod/$name.ko; "
done
case $mode in
  vcan) bus="/full/ip link add dev vcan0 type vcan; /full/ip link set vcan0 up" ;;
  kvaser) bus="for i in 0 1; do /full/ip link set can\$i type can bitrate 1000000 restart-ms 100; /full/ip link set can\$i up; done" ;;
  slcan) bus="slcand -o -s8 -S 115200 ttyS1 sl0; sleep 0.3; /full/ip link set sl0 up" ;;
esac
cat >"$root/init" <<EOF
#!/bin/busybox sh
/bin/busybox --install -s /bin 2>/dev/null
export PATH=/full:/bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs dev /dev
$load
/full/ip link set lo up
$bus
/bin/trial $mode
echo "STATUS=\$?"
poweroff -f
EOF
chmod +x "$root/init"
(cd "$root" && find . | cpio -o -H newc --quiet | gzip -1) >"initrd-$mode.gz"

# Where nothing outside takes part, time in the machine runs with its instructions: a busy host does not stop it.
hardware=(-icount "shift=2,sleep=off")
case $mode in
  kvaser) hardware+=(-object can-bus,id=bus -device kvaser_pci,canbus=bus -device kvaser_pci,canbus=bus) ;;
  slcan) hardware=(-serial "${PEER_TTY:?names the terminal of the nodes}") ;;
esac
timeout 150 qemu-system-x86_64 -M q35 -accel tcg,thread=single -m 384 -smp 1 -nographic -no-reboot \
  -nodefaults -serial stdio "${hardware[@]}" -kernel vmlinux -initrd "initrd-$mode.gz" \
  -append "console=ttyS0 quiet panic=-1 tsc=reliable no_timer_check mitigations=off" </dev/null 2>&1 | tr -d '\r' | tee "last-$mode.log"
status=$(sed -n 's/^.*STATUS=//p' "last-$mode.log" | tail -1)
exit "${status:-125}"
