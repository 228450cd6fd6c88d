# Debian packages by section of packages.apt: each verb installs what it needs, and says what for. Sourced.

package_sections() { sed -n 's/^## \([a-z]*\): .*/\1/p' packages.apt; }
section_purpose() { sed -n "s/^## $1: //p" packages.apt; }  # SECTION
section_packages() {  # SECTION: one word per package
  local packages_release
  # shellcheck disable=SC1091 # of the system
  packages_release=$(. /etc/os-release 2>/dev/null && echo "${VERSION_CODENAME:-}")
  awk -v section="$1" -v release="$packages_release" '
    /^## / { here = $2 == section ":" }
    /^#/ || !here { next }
    $1 ~ /:$/ { if ($1 != release ":") next; $1 = "" }
    { print }' packages.apt
}

# dpkg-query, apt-get and sudo are those of the caller's path: who puts another one in front has a reason. All other programs
# are Debian's (start.sh).
callers_program() { PATH="$CALLER_PATH:$PATH" command -v "$1"; }  # NAME

installed_packages() {  # NAME VERSION PROVIDED... of each, a line
  # shellcheck disable=SC2016 # fields of dpkg's
  "$(callers_program dpkg-query || echo false)" -W -f='${db:Status-Status} ${Package} ${Version} ${Provides}\n' 2>/dev/null |
    awk '$1 == "installed" { gsub(/\([^)]*\)|,/, " "); $1 = ""; print }'
}

missing_packages() {  # PACKAGE...: those that neither are installed nor are part of one that is (another nodejs brings npm along)
  installed_packages | awk -v wanted="$*" '
    { for (i = 1; i <= NF; ++i) if (i != 2) here[$i] = 1 }
    END { n = split(wanted, each, " "); for (i = 1; i <= n; ++i) if (!(each[i] in here) && !told[each[i]]++) printf "%s ", each[i] }'
}

# Changes when a package of packages.apt comes, goes or is another version, by whatever way: what CMake finds follows it.
installed_key() {
  local key_section key_listed
  key_listed=$(for key_section in $(package_sections); do section_packages "$key_section"; done | tr '\n' ' ')
  installed_packages | awk -v listed="$key_listed" '
    BEGIN { n = split(listed, each, " "); for (i = 1; i <= n; ++i) here[each[i]] = 1 }
    $1 in here { print $1, $2 }' | sort | cksum
}

# ROS resolves localhost by name; a bare system has no /etc/hosts.
ensure_localhost() {
  getent hosts localhost >/dev/null 2>&1 && return
  if [ -w /etc/hosts ] || { [ ! -e /etc/hosts ] && [ -w /etc ]; }; then
    echo '127.0.0.1 localhost' >>/etc/hosts
  else
    fail "localhost has no address; as root: echo '127.0.0.1 localhost' >> /etc/hosts"
  fi
}

# Whoever called sudo owns what was made here for him.
give_to_caller() {
  [ "$(id -u)" != 0 ] || [ -z "${SUDO_UID:-}" ] || [ ! -d "$BUILD" ] || chown -R "$SUDO_UID:${SUDO_GID:-$SUDO_UID}" "$BUILD"
}

ensure_build_folder() {
  mkdir -p "$BUILD" "$LOGS" "$FIGURES" 2>/dev/null && [ -w "$BUILD" ] && [ -w "$LOGS" ] && [ -w "$FIGURES" ] && return
  fail "$BUILD cannot be written by $(id -un); if root made it: sudo chown -R $(id -un): '$BUILD'"
}

setup() {  # SECTION...: installs what these sections lack
  local setup_section setup_lacking setup_missing setup_purposes setup_sections
  ensure_build_folder
  setup_missing='' setup_purposes='' setup_sections=''
  for setup_section; do
    # shellcheck disable=SC2046 # one word per package
    setup_lacking=$(missing_packages $(section_packages "$setup_section"))
    [ -n "$setup_lacking" ] || continue
    setup_missing="$setup_missing $setup_lacking" setup_sections="$setup_sections $setup_section"
    setup_purposes="$setup_purposes${setup_purposes:+; }$setup_section: $(section_purpose "$setup_section")"
  done
  if [ -n "$setup_missing" ]; then
    # shellcheck disable=SC2086 # one word per section or package
    if [ "$(id -u)" = 0 ]; then install_packages "$setup_purposes" $setup_missing; else install_as_root "$setup_sections" $setup_missing; fi
  fi
  ensure_localhost
}

# sudo asks for its password on the terminal; without one it must need none. The setup that it runs shows its own progress.
install_as_root() {  # SECTIONS PACKAGE...
  local root_sections root_sudo
  root_sections=$1
  shift
  root_sudo=$(callers_program sudo) || root_sudo=''
  if [ -n "$root_sudo" ] && { { [ -t 0 ] && [ -t 2 ]; } || "$root_sudo" -n true 2>/dev/null; }; then
    echo "setup: root installs Debian packages; sudo may ask for your password" >&2
    # shellcheck disable=SC2016,SC2086 # expanded by the inner shell; one word per section
    PATH="$CALLER_PATH:$PATH" "$root_sudo" -- sh -c '[ "$(id -u)" = 0 ] && exec "$@"' sh "$ROOT/launch/verbs/setup.sh" ${SETUP_BUILDS:+--builds "$SETUP_BUILDS"} \
      $root_sections && return
    fail "setup was refused or failed; as root: apt-get update && apt-get install -y --no-install-recommends $*"
  fi
  fail "packages are missing; as root: apt-get update && apt-get install -y --no-install-recommends $*"
}

APT_CONF=$ROOT/launch/verbs/parts/apt.conf

install_packages() {  # PURPOSES PACKAGE...
  local install_purposes install_apt install_cost
  install_purposes=$1
  shift
  install_apt=$(callers_program apt-get) || fail "no apt-get here: install what packages.apt lists by your own means"
  with_progress_or_log packages "$LOGS/packages.log" "$install_apt" -c "$APT_CONF" update
  export DEBIAN_FRONTEND=noninteractive
  INTERRUPT=gently
  if [ -n "$(dpkg --audit 2>/dev/null)" ]; then
    echo 'setup: dpkg was interrupted; it finishes that first' >&2
    with_progress configure "$LOGS/configure.log" dpkg --configure -a --force-confold  # what it cannot, apt mends below
  fi
  install_cost=$(first_cost "$install_apt" "$@") || exit 1
  echo "setup: $install_cost, for $install_purposes" >&2
  # Nothing is ever removed for ours.
  with_progress_or_log setup "$LOGS/setup.log" "$install_apt" -c "$APT_CONF" install -y --fix-broken --no-remove --no-install-recommends "$@"
  INTERRUPT=''
  give_to_caller
}
