# What script/run, script/test and script/fuzz share. Sourced, not run.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

die() { echo "$(basename "$0"): error: $*" >&2; exit 1; }

# install_packages GROUP...: installs what script/packages.txt lists for these groups and the machine lacks. Asks dpkg
# first, so that a second call needs neither the network nor any right.
install_packages() {
  local group wanted=() missing=() package
  for group in "$@"; do
    mapfile -t -O "${#wanted[@]}" wanted < <(awk -v g="$group" '$1 == g { print $2 }' "$root/script/packages.txt")
  done
  for package in "${wanted[@]}"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  local as=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || die "these packages are missing and only root can install them: ${missing[*]}"
    as=(sudo)
  fi
  echo "installing ${missing[*]}" >&2
  "${as[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq >&2 || die "the package lists cannot be fetched"
  "${as[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2 ||
    die "packages could not be installed"
}

# build PRESET [TARGET...]: configures and builds; quiet while all goes well. Configures every time: packages that were
# installed since, such as those of the tests, are found only then.
build() {
  local preset=$1 log
  shift
  log=$(mktemp)
  if ! (cd "$root" && cmake --preset "$preset" ${CHOREO_CMAKE_ARGS:-}) >"$log" 2>&1; then
    cat "$log" >&2
    rm -f "$log"
    die "configuring failed"
  fi
  if ! cmake --build "$root/build/$preset" ${1:+--target "$@"} >"$log" 2>&1; then
    grep -vE '^\[[0-9]+/[0-9]+\]' "$log" >&2
    rm -f "$log"
    die "building failed"
  fi
  rm -f "$log"
}
