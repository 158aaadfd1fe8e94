# Sourced by run-study and run-tests: installs what is missing, by Debian package name. Says what it does.

REQUIRED_PACKAGES="g++ cmake ninja-build pkg-config git libeigen3-dev libboost-dev libcli11-dev libfmt-dev
  nlohmann-json3-dev libsqlite3-dev librandom123-dev libxxhash-dev libflint-dev zlib1g-dev"
# Figures of the report, and faster second builds: good to have, not needed.
HELPFUL_PACKAGES="ccache"
# Each of these brings adapters; without it they are left out, and `lcpbench solvers` says so.
ADAPTER_PACKAGES="libbullet-dev coinor-libipopt-dev libode-dev libsiconos-numerics-dev
  libdart-external-odelcpsolver-dev libsuitesparse-dev"

say() { printf '%s\n' "$*" >&2; }

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

# Configures and builds one preset: build_preset NAME [cmake options...] [-- targets...]
build_preset() {
  local preset=$1 options=() targets=()
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
  [ $# -eq 0 ] || { shift; targets=("$@"); }
  say "Building ($preset) ..."
  cmake --preset "$preset" "${options[@]}" > "build/$preset.configure.log" 2>&1 ||
    { cat "build/$preset.configure.log" >&2; exit 1; }
  cmake --build "build/$preset" ${targets[@]:+--target "${targets[@]}"} > "build/$preset.build.log" 2>&1 ||
    { grep -nE 'error|FAILED|undefined reference' "build/$preset.build.log" >&2; tail -n 40 "build/$preset.build.log" >&2; exit 1; }
}
