# To be sourced. Packages of a Debian suite without root, and without a change to this system: apt-get with lists of its
# own. Debian's keys check what it downloads.

fail() { echo "${0##*/}: $*" >&2; exit 1; }

# use_suite FOLDER SUITE: the functions below then read the suite's packages and sources; its lists are kept in
# FOLDER/SUITE. Does nothing if the suite is in use. Fails if the lists can't be downloaded.
suite=
use_suite() {
  [[ $suite != "$2" ]] || return 0
  suite=$2
  local folder=$1/$2
  local signed="[signed-by=/usr/share/keyrings/debian-archive-keyring.gpg]" kind
  mkdir -p "$folder/state/lists/partial" "$folder/cache/archives/partial"
  for kind in deb deb-src; do
    echo "$kind $signed http://deb.debian.org/debian $suite main"
    [[ $suite == sid ]] || echo "$kind $signed http://deb.debian.org/debian-security $suite-security main"
  done >"$folder/sources.list"
  apt_options=(
    -o "Dir::State=$folder/state" -o "Dir::State::status=/dev/null" -o "Dir::Cache=$folder/cache"
    -o "Dir::Etc::SourceList=$folder/sources.list" -o "Dir::Etc::SourceParts=/dev/null"
    -o "Acquire::Retries=3" -o "APT::Sandbox::User=root" -o "APT::Get::Only-Source=true"
    -o "APT::Cache::Only-Source=true")
  apt-get -q "${apt_options[@]}" update || {
    echo "${0##*/}: the package lists of Debian's $suite can't be downloaded: see the lines above" >&2
    suite=
    return 1
  }
}

# versions show|showsrc NAME: of a package or a source package in the suite, the newest first.
versions() { apt-cache "${apt_options[@]}" "$1" "$2" | sed -n 's/^Version: //p' | sort -urV; }

# download_package NAME: the newest version in the suite that can be downloaded, into the current folder. A mirror may lack
# files that its lists name.
download_package() {
  local version
  for version in $(versions show "$1"); do
    ! apt-get -q "${apt_options[@]}" download "$1=$version" || return 0
  done
  fail "the package $1 of Debian's $suite can't be downloaded: see the lines above"
}

# download_source LISTS FOLDER NAME SUITE...: a source package, unpacked in FOLDER: the newest version that can be downloaded
# from the first suite that has one. LISTS is the folder for use_suite.
download_source() {
  local lists=$1 to=$2 name=$3 from version work missing=
  shift 3
  for from in "$@"; do
    use_suite "$lists" "$from" || continue
    for version in $(versions showsrc "$name"); do
      work=$(mktemp -d "$to/download.XXXXXX")
      if (cd "$work" && apt-get -q "${apt_options[@]}" source "$name=$version"); then
        mv "$work"/*/ "$to"
        rm -rf "$work"
        echo "${0##*/}: $name $version of Debian's $from${missing:+ is used, because the mirror lacks $missing}"
        return
      fi
      rm -rf "$work"
      missing+="${missing:+, }$version"
    done
  done
  fail "the source package $name can't be downloaded from Debian's $*: see the lines above"
}

# The fields of a package that scripts/sbom reads, in its order.
package_fields='${Package}\t${Version}\t${Architecture}\t${source:Package}\t${source:Version}\t${Homepage}\n'

# unpack_packages FOLDER PACKAGE...: from the suite into the folder; prints the fields of each. Nothing is configured. Links
# to absolute paths are made relative, so that they lead to files of the folder.
unpack_packages() {
  local to=$1 work package file link
  shift
  work=$(mktemp -d)
  for package in "$@"; do
    (cd "$work" && download_package "$package" >&2)
  done
  for file in "$work"/*.deb; do
    dpkg -x "$file" "$to"
    dpkg-deb --show --showformat="$package_fields" "$file"
  done
  rm -rf "$work"
  find "$to" -type l -lname '/*' | while read -r link; do
    ln -sfnr "$to$(readlink "$link")" "$link"
  done
}

# copy_notices ROOT FOLDER: of the packages whose fields are on standard input, from ROOT/usr/share/doc.
copy_notices() {
  local root=$1 to=$2 package source rest
  mkdir -p "$to"
  while IFS=$'\t' read -r package _ _ source rest; do
    install -m 644 "$root/usr/share/doc/$package/copyright" "$to/$source.txt"
  done
}
