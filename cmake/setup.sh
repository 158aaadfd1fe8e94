# Sourced by run-study and run-tests: installs what is missing, by Debian package name. Says what it does.

REQUIRED_PACKAGES="g++ cmake ninja-build pkg-config git libeigen3-dev libcli11-dev libfmt-dev
  nlohmann-json3-dev libsqlite3-dev librandom123-dev libxxhash-dev libflint-dev libgmp-dev zlib1g-dev
  libzstd-dev"
# Faster second builds: good to have, not needed.
HELPFUL_PACKAGES="ccache"
# Each of these brings adapters; without it they are left out, and `lcpbench solvers` says so.
ADAPTER_PACKAGES="libbullet-dev coinor-libipopt-dev libode-dev libsiconos-numerics-dev
  libdart-dev libsimbody-dev libsuitesparse-dev
  libmujoco-dev libmujoco-samples"

say() { printf '%s\n' "$@" >&2; }

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

is_installed() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

missing_of() {
  local package
  for package in "$@"; do is_installed "$package" || printf '%s ' "$package"; done
}

# install_packages REQUIRED... -- OPTIONAL...
install_packages() {
  local required="" optional="" rest=no package wanted
  for package in "$@"; do
    if [ "$package" = -- ]; then rest=yes
    elif [ $rest = no ]; then required="$required $package"
    else optional="$optional $package"; fi
  done
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    say "This system has no apt-get: install by hand what these Debian packages hold:$required (optional:$optional)"
    return
  fi
  required=$(missing_of $required)
  optional=$(missing_of $optional)
  [ -n "$required$optional" ] || return 0
  say "Missing packages: $required$optional"
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      [ -z "$required" ] || { say "Not root and no sudo: install them yourself: apt-get install $required"; exit 2; }
      return 0
    fi
    say "Installing them with sudo apt-get."
  fi
  as_root apt-get update -qq || say "apt-get update failed; going on with the package lists at hand."
  wanted="$required"
  for package in $optional; do
    if apt-cache show "$package" >/dev/null 2>&1; then
      wanted="$wanted $package"
    else
      say "$package does not exist on this distribution; what needs it is left out."
    fi
  done
  [ -n "${wanted// /}" ] || return 0
  if ! as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $wanted >&2; then
    say "Together they would not install; trying one by one."
    for package in $wanted; do
      as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$package" >&2 && continue
      case " $required " in *" $package "*) say "$package is required and would not install."; exit 2 ;; esac
      say "$package would not install; what needs it is left out."
    done
  fi
}

# Ends the script: failed WHAT LOG. The lines that say why come first, then the last lines, and the log's path at the end.
failed() {
  say "" "$1 failed. Lines with errors:"
  grep -m 20 -nE 'error|Error|FAILED|undefined reference' "$2" >&2 || say "(none)"
  say "" "The last lines:"
  tail -n 30 "$2" >&2 || true
  say "" "$1 failed. Everything it printed is in $2"
  exit 1
}

# Reads ninja's output and shows its count: on one line of a terminal, otherwise about every tenth of the work.
show_progress() {
  local line count total tenth shown=0
  while IFS= read -r line; do
    [[ $line =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
    count=${BASH_REMATCH[1]} total=${BASH_REMATCH[2]}
    tenth=$((count * 10 / total))
    if [ -t 2 ]; then
      printf '\r  %d of %d steps ' "$count" "$total" >&2
    elif [ $tenth -ne $shown ]; then
      say "  $count of $total steps"
    fi
    shown=$tenth
  done
  if [ -t 2 ] && [ -n "${total:-}" ]; then say ""; fi
}

# Configures and builds one preset: build_preset NAME [cmake options...] [-- targets...]. Needs `set -o pipefail`.
build_preset() {
  local preset=$1 log="build/$1.build.log" options=() targets=()
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
  [ $# -eq 0 ] || { shift; targets=("$@"); }
  say "Building ($preset); the compiler's messages go to $log ..."
  cmake --preset "$preset" "${options[@]}" > "build/$preset.configure.log" 2>&1 ||
    failed "Configuring ($preset)" "build/$preset.configure.log"
  NINJA_STATUS='[%f/%t] ' cmake --build "build/$preset" ${targets[@]:+--target "${targets[@]}"} 2>&1 |
    tee "$log" | show_progress ||
    failed "Building ($preset)" "$log"
}
