// Binds a class of plain fields. Each field is a property that checks assigned values; all of them are keyword
// arguments of the constructor, and repr() shows them.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "values.h"

namespace latelight::python {

template <typename T>
class Fields {
 public:
  Fields(nb::module_& module, const char* name, const char* doc) : type_(module, name, doc), name_(name) {}

  // `type` is the type in the stub. `get` returns a Python object for a const T&; `set` receives a T&, a value and the
  // name.
  template <typename Get, typename Set>
  Fields& field(const char* name, const char* type, const char* doc, Get get, Set set) {
    const std::string getSignature = fmt::format("def {}(self) -> {}", name, type);
    const std::string setSignature = fmt::format("def {}(self, value: {}, /) -> None", name, writable(type));
    const std::string text = doc;
    type_.def_prop_rw(
        name, get, [name, set](T& self, nb::handle value) { set(self, value, name); },
        nb::for_getter(nb::sig(getSignature.c_str())), nb::for_setter(nb::sig(setSignature.c_str())),
        nb::for_setter(nb::arg("value").none()), text.c_str());
    parameters_ += fmt::format(", {}: {} = ...", name, writable(type));
    names_.push_back(name);
    return *this;
  }

  Fields& number(const char* name, float T::*member, const char* doc) {
    return field(
        name, "float", doc, [member](const T& self) { return nb::float_(self.*member); },
        [member](T& self, nb::handle value, const char* name) { self.*member = floatOf(value, name); });
  }
  Fields& number(const char* name, double T::*member, const char* doc) {
    return field(
        name, "float", doc, [member](const T& self) { return nb::float_(self.*member); },
        [member](T& self, nb::handle value, const char* name) { self.*member = numberOf(value, name); });
  }
  Fields& flag(const char* name, bool T::*member, const char* doc) {
    return field(
        name, "bool", doc, [member](const T& self) { return self.*member; },
        [member](T& self, nb::handle value, const char* name) { self.*member = boolOf(value, name); });
  }
  Fields& text(const char* name, std::string T::*member, const char* doc) {
    return field(
        name, "str", doc, [member](const T& self) { return nb::str((self.*member).c_str()); },
        [member](T& self, nb::handle value, const char* name) { self.*member = textOf(value, name); });
  }
  template <typename Number, size_t N>
  Fields& numbers(const char* name, std::array<Number, N> T::*member, const char* doc) {
    return field(
        name, "tuple[float, ...]", doc, [member](const T& self) { return tupleOf(self.*member); },
        [member](T& self, nb::handle value, const char* name) { self.*member = numbersOf<Number, N>(value, name); });
  }

  // Must be called after all fields.
  nb::class_<T>& done() {
    defineInit();
    defineRepr();
    definePickling();
    return type_;
  }

 private:
  using Names = std::vector<std::string>;

  // Assigns values by keyword to an object that is already constructed.
  static void set(nb::handle self, const nb::dict& values, const Names& names, const char* type) {
    for (const auto& [name, value] : values) {
      const std::string text = shown(nb::borrow(name));
      if (std::ranges::find(names, text) == names.end()) badType("{} has no \"{}\"", type, text);
      nb::setattr(self, name, value);
    }
  }

  static void make(nb::handle self) {
    new (nb::inst_ptr<T>(self)) T();
    nb::inst_mark_ready(self);
  }

  void defineInit() {
    const std::string signature = "def __init__(self, *" + parameters_ + ") -> None";
    type_.def(
        "__init__",
        [names = names_, type = name_](nb::handle self, const nb::kwargs& values) {
          if (!nb::inst_ready(self)) make(self);
          set(self, values, names, type);
        },
        nb::sig(signature.c_str()));
  }

  void defineRepr() {
    type_.def("__repr__", [names = names_, type = name_](nb::handle self) {
      std::string text;
      for (const std::string& name : names)
        text += fmt::format("{}{}={}", text.empty() ? "" : ", ", name,
                            nb::cast<std::string>(nb::repr(nb::getattr(self, name.c_str()))));
      return fmt::format("{}({})", type, text);
    });
  }

  // Pickling allows copies, and transfers to other processes.
  void definePickling() {
    type_.def("__getstate__", [names = names_](nb::handle self) {
      nb::dict state;
      for (const std::string& name : names) state[name.c_str()] = nb::getattr(self, name.c_str());
      return state;
    });
    type_.def(
        "__setstate__",
        [names = names_, type = name_](nb::handle self, nb::handle state) {
          requireState(state, names, type);
          if (!nb::inst_ready(self)) make(self);
          set(self, nb::borrow<nb::dict>(state), names, type);
        },
        nb::arg("state").none(), nb::sig("def __setstate__(self, state: dict[str, typing.Any]) -> None"));
  }

  // Requires exactly these fields, so states of other versions and other classes are rejected.
  static void requireState(nb::handle state, const Names& names, const char* type) {
    if (!PyDict_Check(state.ptr())) badType("the state of a {} must be a dict, not {}", type, typeName(state));
    const auto values = nb::borrow<nb::dict>(state);
    for (const std::string& name : names)
      if (!values.contains(name.c_str())) badValue("the state of a {} must have \"{}\"", type, name);
    if (values.size() != names.size()) badValue("the state of a {} must have nothing but its fields", type);
  }

  static std::string writable(const char* type) {
    const std::string text = type;
    if (text.starts_with("tuple[")) return "collections.abc.Sequence[float]";
    return text == "numpy.ndarray" ? "numpy.typing.ArrayLike" : text;
  }

  nb::class_<T> type_;
  const char* name_;
  std::string parameters_;
  std::vector<std::string> names_;
};

}  // namespace latelight::python
