# What script/run, script/test and script/fuzz share. Sourced, not run.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

die() { echo "$(basename "$0"): error: $*" >&2; exit 1; }
misused() { echo "$(basename "$0"): error: $*; see script/$(basename "$0") --help" >&2; exit 2; }

# step WHAT: one line on standard error for what begins; tell_steps: how long each took.
steps=()
step() {
  local now=$SECONDS
  [ ${#steps[@]} -eq 0 ] || steps[-1]="$((now - step_began)) ${steps[-1]}"
  step_began=$now
  steps+=("$1")
  echo "$(basename "$0"): $1" >&2
}
tell_steps() {
  [ ${#steps[@]} -gt 0 ] || return 0
  steps[-1]="$((SECONDS - step_began)) ${steps[-1]}"
  local each
  for each in "${steps[@]}"; do printf '%3d min %02d s  %s\n' $((${each%% *} / 60)) $((${each%% *} % 60)) "${each#* }"; done
  printf '%3d min %02d s  in all\n' $((SECONDS / 60)) $((SECONDS % 60))
}

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
  local log=$root/build/packages.log
  mkdir -p "$root/build"
  step "installing ${#missing[@]} packages"
  {
    "${as[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq &&
      "${as[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
  } >"$log" 2>&1 && return
  grep -E '^E:' "$log" >&2 || tail -n 3 "$log" >&2
  die "these packages could not be installed: ${missing[*]}; all that apt-get said is in $log"
}

# bring_models: the person network, by npm, into the cache where the program looks for it. Without npm, the network or a
# home the program works and says what it lacks, so nothing here is a failure; it is tried again after a day.
bring_models() {
  local cache=${XDG_CACHE_HOME:-} package=@mediapipe/pose@0.5.1675469404 log=$root/build/models.log load
  [ "${cache:0:1}" = / ] || cache=${HOME:-}/.cache
  local folder=$cache/choreoscope/models
  check_models() { (cd "$1" 2>/dev/null && sha256sum --check --status "$root/script/models.sha256"); }
  check_models "$folder" && return
  [ -z "$(find "$log" -mtime -1 2>/dev/null)" ] || return 0
  mkdir -p "$root/build"
  step "bringing the person network ($package, Apache-2.0) into $folder"
  command -v npm >/dev/null || (install_packages models) || true
  load=$(mktemp -d)
  if {
    (cd "$load" && npm pack --loglevel=error --fetch-retries=0 --fetch-timeout=60000 "$package" && tar -xzf ./*.tgz) &&
      mv "$load/package/pose_solution_packed_assets.data" "$load/package/pose_detection.tflite" &&
      check_models "$load/package" &&
      mkdir -p "$folder" &&
      (cd "$load/package" && install -m 644 $(awk '{ print $2 }' "$root/script/models.sha256") "$folder")
  } >"$log" 2>&1; then
    rm -f "$log"
  else
    tail -n 2 "$log" >&2
    echo "$(basename "$0"): the person network could not be had: no joints, and no masks of people; all that was said is in $log" >&2
  fi
  rm -rf "$load"
}

# build PRESET [TARGET...]: configures and builds; quiet while all goes well. Configures every time: packages that were
# installed since, such as those of the tests, are found only then.
build() {
  local preset=$1 log=$root/build/$1.log
  shift
  mkdir -p "$root/build"
  if ! (cd "$root" && cmake --preset "$preset") >"$log" 2>&1; then
    cat "$log" >&2
    die "configuring failed; see $log"
  fi
  if ! cmake --build "$root/build/$preset" ${1:+--target "$@"} >"$log" 2>&1; then
    grep -vE '^\[[0-9]+/[0-9]+\]' "$log" >&2
    die "building failed; all of it is in $log"
  fi
}
