# The comments of a header as Doxygen wants them: /// before a declaration, ///< behind one, and on the lines that go on
# from there.
/^ *\/\// { sub(/\/\//, match($0, /[^ ]/) > 12 ? "///<" : "///"); print; next }
{ sub(/  \/\/ /, "  ///< "); print }
