# A kernel for an emulated computer, in the present folder: sourced. Makes kernel/ (the package unpacked) and vmlinux; sets vmlinuz.
# Debian's generic kernel: the cloud flavour has no CAN.
if ! ls kernel/boot/vmlinuz-* >/dev/null 2>&1; then
  package=$(apt-cache depends linux-image-amd64 | sed -n 's/.*Depends: \(linux-image-[0-9].*\)/\1/p' | head -1)
  apt-get download -q "$package" >/dev/null 2>&1
  mkdir -p kernel
  dpkg-deb -x "$package"_*.deb kernel
  rm -f "$package"_*.deb
fi
vmlinuz=$(echo kernel/boot/vmlinuz-*)
# The emulated processor would take long to unpack the kernel: it is given the unpacked one (booted by its PVH note).
[ -s vmlinux ] || python3 - "$vmlinuz" vmlinux <<'EOF'
import lzma, sys
image = open(sys.argv[1], "rb").read()
start = image.find(b"\xfd7zXZ\0")
while start >= 0:
    try:
        unpacked = lzma.LZMADecompressor().decompress(image[start:])
        if unpacked[:4] == b"\x7fELF":
            open(sys.argv[2], "wb").write(unpacked)
            break
    except lzma.LZMAError:
        pass
    start = image.find(b"\xfd7zXZ\0", start + 1)
else:
    sys.exit("no kernel packed with xz in " + sys.argv[1])
EOF
