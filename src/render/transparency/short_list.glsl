// Sorts a short list of fragments with one invocation.
uint64_t shortKeys[kShortList];
uint shortList[kShortList];  // indices of fragments

// Fills both arrays with `count` fragments from `first` on, sorted back to front. Insertion sort is fast for nearly
// sorted input.
void sortShortList(FragmentLists lists, uint first, uint count) {
  for (uint i = 0u; i < count; ++i) {
    uint fragment = ListWordsRef(lists.lists).v[first + i];
    uint64_t key = sortKeyOf(lists, fragment);
    uint place = i;
    while (place > 0u && shortKeys[place - 1u] > key) {
      shortKeys[place] = shortKeys[place - 1u];
      shortList[place] = shortList[place - 1u];
      --place;
    }
    shortKeys[place] = key;
    shortList[place] = fragment;
  }
}
