// Binds the elements of a scene: handles, and the properties of each element.
#include <nanobind/operators.h>

#include "bindings.h"
#include "fields.h"

namespace latelight::python {

namespace {

template <typename Element>
void bindHandle(nb::module_& module, const char* name, const char* doc) {
  using H = Handle<Element>;
  nb::class_<H>(module, name, doc)
      .def(
          "__eq__",
          [](const H& self, nb::handle other) {
            const H* that = nullptr;
            return nb::try_cast<const H*>(other, that, false) && that && self == *that;
          },
          nb::arg("other").none(), nb::sig("def __eq__(self, other: object, /) -> bool"))
      .def("__copy__", [](nb::handle self) { return nb::borrow(self); })
      .def(
          "__deepcopy__", [](nb::handle self, nb::handle) { return nb::borrow(self); }, nb::arg("memo"))
      .def("__hash__", [](const H& self) { return nb::hash(nb::make_tuple(self.scene, self.index, self.generation)); })
      .def("__repr__", [name](const H& self) { return fmt::format("{}({}, scene {})", name, self.index, self.scene); });
}

constexpr const char* kAlphaModes[] = {"opaque", "mask", "blend"};  // in the order of AlphaMode

void setAlphaMode(Material& material, nb::handle value, const char* name) {
  const std::string text = textOf(value, name);
  for (size_t i = 0; i < std::size(kAlphaModes); ++i) {
    if (text != kAlphaModes[i]) continue;
    material.alphaMode = static_cast<AlphaMode>(i);
    return;
  }
  badValue("{} must be opaque, mask or blend, not \"{}\"", name, text);
}

void bindMaterial(nb::module_& module) {
  Fields<Material>(module, "Material",
                   "glTF's metallic-roughness material. Factors multiply the textures that the material has.")
      .text("name", &Material::name, "given when it is added")
      .numbers("base_color", &Material::baseColor, "linear Rec.709, and alpha")
      .number("metallic", &Material::metallic, "0 to 1")
      .number("roughness", &Material::roughness, "0 to 1")
      .numbers("emissive", &Material::emissive, "radiance; may be above 1")
      .field(
          "alpha_mode", "str", "opaque, mask or blend",
          [](const Material& m) { return nb::str(kAlphaModes[static_cast<size_t>(m.alphaMode)]); }, setAlphaMode)
      .number("alpha_cutoff", &Material::alphaCutoff, "with the alpha mode mask: points with less alpha are removed")
      .flag("double_sided", &Material::doubleSided, "its back shows too")
      .flag("unlit", &Material::unlit, "the base color is shown as it is")
      .number("normal_scale", &Material::normalScale, "of the normal map's slopes")
      .number("occlusion_strength", &Material::occlusionStrength, "0 to 1")
      .number("specular", &Material::specular, "KHR_materials_specular")
      .numbers("specular_color", &Material::specularColor, "linear Rec.709")
      .number("f0", &Material::f0, "what a dielectric reflects at normal incidence: ((ior - 1) / (ior + 1))^2")
      .number("clearcoat", &Material::clearcoat, "KHR_materials_clearcoat: 0 (none) to 1")
      .number("clearcoat_roughness", &Material::clearcoatRoughness, "0 to 1")
      .number("clearcoat_normal_scale", &Material::clearcoatNormalScale, "of the coat's own normal map's slopes")
      .numbers("sheen_color", &Material::sheenColor, "KHR_materials_sheen: linear Rec.709, 0 to 1; black: none")
      .number("sheen_roughness", &Material::sheenRoughness, "0 to 1")
      .number("anisotropy", &Material::anisotropy, "KHR_materials_anisotropy: 0 (none) to 1")
      .number("anisotropy_rotation", &Material::anisotropyRotation, "degrees, counter-clockwise from the tangent")
      .number("iridescence", &Material::iridescence, "KHR_materials_iridescence: 0 (none) to 1")
      .number("iridescence_ior", &Material::iridescenceIor, "index of refraction of the film, at least 1")
      .number("iridescence_thinnest", &Material::iridescenceThinnest, "nanometers, where the texture is 0")
      .number("iridescence_thickest", &Material::iridescenceThickest,
              "nanometers, where the texture is 1, or everywhere without one")
      .number("transmission", &Material::transmission, "KHR_materials_transmission: 0 (none) to 1")
      .number("thickness", &Material::thickness,
              "KHR_materials_volume: meters in object space; 0: the surface is thin-walled")
      .numbers("attenuation_color", &Material::attenuationColor,
               "linear Rec.709, 0 to 1: what is left of white light after attenuation_distance")
      .number("attenuation_distance", &Material::attenuationDistance, "meters; infinite: nothing is lost")
      .number("dispersion", &Material::dispersion, "KHR_materials_dispersion: 20 / the Abbe number; 0: none")
      .number("diffuse_transmission", &Material::diffuseTransmission,
              "KHR_materials_diffuse_transmission: 0 (none) to 1")
      .numbers("diffuse_transmission_color", &Material::diffuseTransmissionColor, "linear Rec.709, 0 to 1")
      .done()
      .def_prop_ro(
          "id", [](const Material& m) { return m.id; }, "as in the output \"material\"; the scene gives it");
}

template <typename T>
nb::object orNone(const std::optional<T>& value) {
  return value ? nb::cast(*value) : nb::none();
}

void bindLight(nb::module_& module) {
  Fields<Light>(module, "Light", "A light of KHR_lights_punctual, or an area light (rect, disk, sphere, tube).")
      .text("name", &Light::name, "")
      .text("type", &Light::type, "point, spot, directional, or another of `latelight list lights`")
      .numbers("position", &Light::position, "meters; not of directional lights")
      .numbers("direction", &Light::direction, "from the light, of any length; not of point lights")
      .numbers("color", &Light::color, "linear Rec.709")
      .number("intensity", &Light::intensity,
              "candela; lux for directional lights, nits (candela per square meter) for area lights")
      .field(
          "range", "float | None", "meters; without one it reaches everything",
          [](const Light& light) { return orNone(light.range); },
          [](Light& light, nb::handle value, const char* name) {
            light.range = value.is_none() ? std::nullopt : std::optional(floatOf(value, name));
          })
      .number("inner_cone", &Light::innerCone, "half angle of spot lights, degrees")
      .number("outer_cone", &Light::outerCone, "half angle of spot lights, degrees")
      .number("size", &Light::size, "radius, meters; of directional lights the angular diameter, degrees")
      .field(
          "cast_shadow", "bool | None", "True: before all lights with None; False: never",
          [](const Light& light) { return orNone(light.castShadow); },
          [](Light& light, nb::handle value, const char* name) {
            light.castShadow = value.is_none() ? std::nullopt : std::optional(boolOf(value, name));
          })
      .number("width", &Light::width, "width of a rect, meters")
      .number("height", &Light::height, "height of a rect, along up, meters")
      .number("length", &Light::length, "length of a tube, which is perpendicular to direction and up, meters")
      .flag("two_sided", &Light::twoSided, "True: both sides of a rect or disk emit")
      .numbers("up", &Light::up, "orientation of an area light about its direction, of any length")
      .numbers("scale", &Light::scale, "of an area light along its own axes: sideways, up, and against direction")
      .done();
}

// --- read-only classes -----------------------------------------------------------------------------------------------

void bindInfos(nb::module_& module) {
  nb::class_<Mesh>(module, "Mesh", "Triangles, as they are at rest.")
      .def_ro("name", &Mesh::name)
      .def_ro("vertices", &Mesh::vertices)
      .def_ro("triangles", &Mesh::triangles)
      .def_prop_ro(
          "bounds", [](const Mesh& m) { return nb::make_tuple(tupleOf(m.boundsMin), tupleOf(m.boundsMax)); },
          nb::sig("def bounds(self) -> tuple[tuple[float, ...], tuple[float, ...]]"),
          "smallest and largest corner, object space, meters")
      .def_ro("deforms", &Mesh::deforms, "a skin or morph targets move its vertices");
  nb::class_<Instance>(module, "Instance", "A mesh placed in the scene.")
      .def_ro("node", &Instance::node, "path of the node that shows it: /Root/Arm/Hand")
      .def_ro("mesh", &Instance::mesh)
      .def_ro("material", &Instance::material)
      .def_prop_ro(
          "transform", [](const Instance& i) { return matrix(i.transform); },
          nb::sig("def transform(self) -> numpy.ndarray"),
          "(4, 4) float64: object space to the scene file's frame, at rest")
      .def_ro("id", &Instance::id, "as in the output \"id\"")
      .def_ro("part", &Instance::part, "as in the output \"part\"");
  nb::class_<Node>(module, "Node", "A node of the file, or one that was added.")
      .def_ro("path", &Node::path)
      .def_ro("parent", &Node::parent, "its path; empty: a root")
      .def_ro("mesh", &Node::mesh, "its name; empty: it has none")
      .def_prop_ro(
          "transform", [](const Node& n) { return matrix(n.transform); },
          nb::sig("def transform(self) -> numpy.ndarray"), "(4, 4) float64: to the scene file's frame, at rest")
      .def_ro("id", &Node::id, "as in the output \"id\"");
  nb::class_<Texture>(module, "Texture", "A texture's name and size.")
      .def_ro("name", &Texture::name)
      .def_ro("width", &Texture::width)
      .def_ro("height", &Texture::height)
      .def_ro("srgb", &Texture::srgb, "its colors are sRGB-encoded");
  nb::class_<Animation>(module, "Animation", "An animation of the scene.")
      .def_ro("name", &Animation::name)
      .def_ro("duration", &Animation::duration, "seconds");
}

}  // namespace

void bindElements(nb::module_& module) {
  bindHandle<Instance>(module, "InstanceHandle", "Identifies an instance of a scene; rejected after its removal.");
  bindHandle<Material>(module, "MaterialHandle", "Identifies a material of a scene; rejected after its removal.");
  bindHandle<Mesh>(module, "MeshHandle", "Identifies a mesh of a scene; rejected after its removal.");
  bindHandle<Light>(module, "LightHandle", "Identifies a light of a scene; rejected after its removal.");
  bindHandle<Skin>(module, "SkinHandle", "Identifies a skin that was added to a scene.");
  bindHandle<Texture>(module, "TextureHandle", "Identifies a texture of a scene; rejected after its removal.");
  bindMaterial(module);
  bindLight(module);
  bindInfos(module);
}

}  // namespace latelight::python
