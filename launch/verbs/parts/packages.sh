# Debian packages by section of packages.apt: each verb installs what it needs, and says what for. Sourced.

package_sections() { sed -n 's/^## \([a-z]*\): .*/\1/p' packages.apt; }
section_purpose() { sed -n "s/^## $1: //p" packages.apt; }  # SECTION
section_packages() {  # SECTION: one word per package
  # shellcheck disable=SC1091 # of the system
  release=$(. /etc/os-release 2>/dev/null && echo "${VERSION_CODENAME:-}")
  awk -v section="$1" -v release="$release" '
    /^## / { here = $2 == section ":" }
    /^#/ || !here { next }
    $1 ~ /:$/ { if ($1 != release ":") next; $1 = "" }
    { print }' packages.apt
}

missing_packages() {  # PACKAGE...: those that neither are installed nor are part of one that is (another nodejs brings npm along)
  dpkg-query -W -f='${db:Status-Status} ${Package} ${Provides}\n' 2>/dev/null |
    awk '$1 == "installed" { gsub(/\([^)]*\)|,/, " "); for (i = 2; i <= NF; ++i) print $i }' >"$BUILD/.installed"
  for package; do grep -qx -- "$package" "$BUILD/.installed" || printf '%s ' "$package"; done
}

install_packages() {  # PURPOSES PACKAGE...
  purposes=$1
  shift
  command -v apt-get >/dev/null || fail "no apt-get here: install what packages.apt lists by your own means"
  prefix=''
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null && sudo -n true 2>/dev/null && prefix=sudo
    [ -n "$prefix" ] || fail "packages are missing; as root: apt-get update && apt-get install -y --no-install-recommends $*"
  fi
  echo "setup: installing $# Debian packages and what they need, for $purposes" >&2
  with_progress_or_log setup "$LOGS/setup.log" $prefix env DEBIAN_FRONTEND=noninteractive \
    sh -c 'apt-get update && apt-get install -y --no-install-recommends "$@"' sh "$@"
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

# A section that was complete for this packages.apt is not looked at again.
setup() {  # SECTION...
  local sum purposes missing new section lacking  # the verbs have variables of such names: demo's --missing-meshes
  mkdir -p "$BUILD"
  sum=$(cksum <packages.apt) purposes='' missing='' new=''
  for section; do
    [ "$(cat "$BUILD/.setup-$section" 2>/dev/null)" != "$sum" ] || continue
    new="$new $section"
    # shellcheck disable=SC2046 # one word per package
    lacking=$(missing_packages $(section_packages "$section"))
    [ -n "$lacking" ] || continue
    missing="$missing $lacking" purposes="$purposes${purposes:+; }$section: $(section_purpose "$section")"
  done
  if [ -n "$missing" ]; then
    # shellcheck disable=SC2086 # one word per package
    install_packages "$purposes" $missing
    rm -f "$BUILD/build.ninja"  # what was not found before may be there now
  fi
  for section in $new; do echo "$sum" >"$BUILD/.setup-$section"; done
  ensure_localhost
}
