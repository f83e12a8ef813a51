# Counts tests: `awk -f summary.awk ctest.xml test_A.xml test_B.xml ...` names what failed and what was skipped and why,
# then prints "N passed, N failed, N skipped". Exit 1 if any failed.
# ctest.xml is `ctest --output-junit`; test_NAME.xml is what GoogleTest wrote for ctest's test NAME. Such a test counts
# as its cases; any other as one; and one that failed though no case of it did (it crashed, it hung) as one more failure.
# Cases that run in part or not at all without `./dev test --all` (tests/long_tests.h) are named before the rest.

function attribute(name,   found) {
  if (!match($0, " " name "=\"[^\"]*\"")) return ""
  found = substr($0, RSTART, RLENGTH)
  sub(/^[^"]*"/, "", found)
  sub(/"$/, "", found)
  return found
}

function plain(text) {
  sub(/^.*&#x0A;/, "", text)  # the place in the source comes before the sentence
  gsub(/&quot;/, "\"", text)
  gsub(/&apos;/, "'", text)
  gsub(/&lt;/, "<", text)
  gsub(/&gt;/, ">", text)
  gsub(/&amp;/, "\\&", text)
  return text
}

function note(kind, name, reason) {
  notes[kind] = notes[kind] "  " kind ": " name (reason == "" ? "" : ": " reason) "\n"
}

FNR == 1 {
  fromCtest = FILENAME ~ /(^|\/)ctest\.xml$/
  program = FILENAME
  sub(/^.*\/test_/, "", program)
  sub(/\.xml$/, "", program)
  if (!fromCtest) counted[program] = 1
}

fromCtest && /^[ \t]*<testcase / {
  name = attribute("name")
  names[++count] = name
  outcome[name] = attribute("status")
}
fromCtest && /^[ \t]*<skipped/ {
  # ctest says "notrun" of a test that skipped itself, and of one whose program is missing.
  if (outcome[name] == "notrun" && attribute("message") !~ /^SKIP_/) outcome[name] = "missing"
}
fromCtest && match($0, /left to \.\/dev test --all: .*/) {  # in the output of a script
  left++
  note("left", name, plain(substr($0, RSTART + 26)))
}
fromCtest { next }

/^[ \t]*<testcase / {
  case_ = attribute("classname") "." attribute("name")
  failing = ""
  if (case_ ~ /InAProcess\.DISABLED_/) {
    # No test, but what one runs in a process of its own.
  } else if (attribute("status") == "notrun") {
    skipped++
    note("skipped", case_, "disabled in its source")
  } else if (attribute("result") == "skipped") {
    skipped++
  } else {
    passed++
  }
}
/^[ \t]*<skipped/ {
  reason = plain(attribute("message"))
  if (reason == "left to ./dev test --all") {
    skipped--
    left++
    note("left", case_, "")
  } else {
    note("skipped", case_, reason)
  }
}
/^[ \t]*<property name="part"/ {
  left++
  note("left", case_, attribute("value"))
}
/^[ \t]*<failure/ && failing != case_ {
  failing = case_
  passed--
  failed++
  failuresOf[program]++
  note("failed", case_, "")
}

END {
  for (i = 1; i <= count; i++) {
    name = names[i]
    if (outcome[name] == "missing") {
      failed++
      note("failed", name, "its program was not built")
    } else if (outcome[name] == "fail" && !failuresOf[name]) {
      failed++
      note("failed", name, name in counted ? "the program ended badly though none of its cases failed" : "")
    } else if (!(name in counted) && outcome[name] == "run") {
      passed++
    } else if (!(name in counted) && outcome[name] != "fail") {
      skipped++
      note("skipped", name, "")
    }
  }
  if (left) printf "%d tests run in part or not at all without ./dev test --all:\n%s", left, notes["left"]
  printf "%s%s", notes["skipped"], notes["failed"]
  printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped
  exit failed > 0
}
