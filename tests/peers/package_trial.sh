# On the emulated computer: the package from its installation to its purge. Prints one line a step with its time, and STATUS at the end.
failed=0
step() { # WORDS COMMAND…
  local words=$1 since=$EPOCHREALTIME shown=
  shift
  # What a person would type.
  [ "$(type -t "$1")" != file ] || shown="\`$*\`"
  if "$@" >/tmp/said 2>&1; then echo "passed: $words | $shown | $(elapsed "$since") s"; else echo "FAILED: $words"; cat /tmp/said; failed=1; fi
}
elapsed() { awk -v from="$1" -v to="$EPOCHREALTIME" 'BEGIN { printf "%.1f", to - from }'; }
until_true() { # SECONDS COMMAND…
  local end=$((SECONDS + $1))
  shift
  until "$@"; do [ $SECONDS -lt $end ] || return 1; sleep 1; done
}
active() { systemctl is-active --quiet trunnion; }
not() { ! "$@"; }
journal_has() { journalctl -u trunnion --no-pager | grep -q "$1"; }
main_pid() { systemctl show -p MainPID --value trunnion; }
came_back() { active && [ "$(main_pid)" != "$1" ]; }

step "installs" dpkg -i /trial/first.deb
step "has its user" id trunnion
step "is enabled" systemctl is-enabled trunnion
step "does not start without a configuration" not active
step "its folders are for the service alone" test "$(stat -c '%a %U' /etc/trunnion /var/lib/trunnion | tr '\n' ' ')" = "750 root 750 trunnion "
step "names what is wrong with a configuration" not trunnion check-config /usr/share/doc/trunnion/README.md
step "takes the example" trunnion check-config /usr/share/doc/trunnion/examples/trunnion.toml
step "lists its commands" trunnion --help
step "has a man page" test -s /usr/share/man/man1/trunnion.1.gz

# The example with its first probe at the second serial line.
sed 's|/dev/serial/by-path/probe-1|/dev/ttyS1|' /usr/share/doc/trunnion/examples/trunnion.toml >/etc/trunnion/trunnion.toml
chown root:trunnion /etc/trunnion/trunnion.toml
chmod 640 /etc/trunnion/trunnion.toml
systemctl start trunnion
step "starts with one" until_true 60 active
step "may open the serial port" until_true 60 journal_has "ttyS1 does not answer"
step "is refused nothing" not journal_has "no permission"
pid=$(main_pid)
kill -9 "$pid"
step "comes back when it is killed" until_true 60 came_back "$pid"
install -o trunnion /trial/run.mcap /var/lib/trunnion/
pid=$(main_pid)
step "upgrades" dpkg -i /trial/second.deb
step "runs the new version" until_true 60 came_back "$pid"
step "keeps the configuration" grep -q ttyS1 /etc/trunnion/trunnion.toml
step "analyses a recording within its limits" until_true 300 grep -qs '"state": "done"' /var/lib/trunnion/run.state.json
touch /var/lib/trunnion/kept
step "is removed" dpkg -r trunnion
step "is stopped" not active
step "the configuration stays" test -e /etc/trunnion/trunnion.toml
step "is purged" dpkg -P trunnion
step "the configuration is gone" not test -e /etc/trunnion
step "recordings stay" test -e /var/lib/trunnion/kept
[ $failed = 0 ] || journalctl -u trunnion --no-pager | tail -40
echo "STATUS=$failed"
