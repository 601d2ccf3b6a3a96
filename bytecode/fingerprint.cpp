#include "bytecode/fingerprint.h"

#include <cstddef>
#include <cstring>
#include <vector>

#include "bytecode/format.h"

namespace plc::bytecode {
namespace {

Image without_places(const Image& image) {
  Image out = image;
  out.project.clear();
  out.product.clear();
  out.files.clear();
  out.drawings.clear();
  out.probes.clear();
  for (ImagePou& pou : out.pous) pou.debug.clear();
  return out;
}

/// Only what `keep` leaves in an empty image, as bytes.
template <class Keep>
bool same(const Image& a, const Image& b, Keep keep) {
  Image only_a, only_b;
  keep(a, only_a);
  keep(b, only_b);
  return save(only_a) == save(only_b);
}

}  // namespace

std::uint64_t fingerprint(const Image& image) {
  const std::vector<std::byte> bytes = save(without_places(image));
  std::uint64_t hash = 0;
  std::memcpy(&hash, bytes.data() + format::kChecksumAt, sizeof hash);
  return hash;
}

std::string difference(const Image& first, const Image& second) {
  const Image a = without_places(first), b = without_places(second);
  if (save(a) == save(b)) return {};
  if (!same(a, b, [](const Image& from, Image& to) { to.options = from.options; })) return "compile options";
  if (!same(a, b, [](const Image& from, Image& to) {
        to.globals = from.globals;
        to.global_initial = from.global_initial;
      })) {
    return "global variables";
  }
  if (!same(a, b, [](const Image& from, Image& to) { to.tasks = from.tasks; })) return "tasks";
  if (a.pous.size() != b.pous.size()) return "number of POUs";
  for (std::size_t i = 0; i < a.pous.size(); ++i) {
    const auto one = [&](auto member) {
      return same(a, b, [&](const Image& from, Image& to) { member(from.pous[i], to.pous.emplace_back()); });
    };
    const std::string of = " of POU " + a.pous[i].name;
    if (a.pous[i].name != b.pous[i].name) return "order of POUs: " + a.pous[i].name + ", " + b.pous[i].name;
    if (!one([](const ImagePou& from, ImagePou& to) { to.instance_initial = from.instance_initial; })) {
      return "variables" + of;
    }
    if (!one([](const ImagePou& from, ImagePou& to) { to.frame_initial = from.frame_initial; })) {
      return "values kept during a call" + of;
    }
    if (!one([](const ImagePou& from, ImagePou& to) { to.code = from.code; })) return "code" + of;
  }
  if (!same(a, b, [](const Image& from, Image& to) { to.types = from.types; })) return "types and names of variables";
  return "library, constants or queues";
}

}  // namespace plc::bytecode
