# To be sourced. Packages of a Debian suite without root, and without a change to this system: apt-get with lists of its
# own. Debian's keys check what it downloads.

# use_suite FOLDER SUITE: apt_get then reads the suite's packages and sources; its lists are kept in FOLDER.
use_suite() {
  local folder=$1 suite=$2
  local signed="[signed-by=/usr/share/keyrings/debian-archive-keyring.gpg]" kind
  mkdir -p "$folder/state/lists/partial" "$folder/cache/archives/partial"
  for kind in deb deb-src; do
    echo "$kind $signed http://deb.debian.org/debian $suite main"
    echo "$kind $signed http://deb.debian.org/debian-security $suite-security main"
  done >"$folder/sources.list"
  apt_options=(
    -o "Dir::State=$folder/state" -o "Dir::State::status=/dev/null" -o "Dir::Cache=$folder/cache"
    -o "Dir::Etc::SourceList=$folder/sources.list" -o "Dir::Etc::SourceParts=/dev/null"
    -o "Acquire::Retries=3" -o "APT::Sandbox::User=root")
  apt_get update
}

apt_get() { apt-get -q "${apt_options[@]}" "$@"; }

# The fields of a package that scripts/sbom reads, in its order.
package_fields='${Package}\t${Version}\t${Architecture}\t${source:Package}\t${source:Version}\t${Homepage}\n'

# unpack_packages FOLDER PACKAGE...: the newest versions in the suite, into the folder; prints the fields of each. Nothing
# is configured. Links to absolute paths are made relative, so that they lead to files of the folder.
unpack_packages() {
  local to=$1 work file link
  shift
  work=$(mktemp -d)
  (cd "$work" && apt_get download "$@" >&2)
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
