// plc sign: keys, and signatures of images, for plants that take signed images alone.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>

#include "engineering/signature.h"
#include "tools/command_line.h"
#include "tools/plc/commands.h"

namespace plc::tools {
namespace {

struct Sign {
  std::string image, key, make_key, output;
};

/// Never one that is there: it may be the only copy of a key.
std::string write_new_file(const std::string& path, const std::string& text, int mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  const bool written = file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const std::string why = written ? "" : fmt::format("cannot write {}: {}", path, std::strerror(errno));
  if (file >= 0) ::close(file);
  return why;
}

int make(const std::string& name) {
  const std::string who = name.substr(name.rfind('/') + 1);
  const engineering::SecretKey key = engineering::make_key(who);
  std::string why = write_new_file(name + ".key", key.line(), 0600);
  if (why.empty()) why = write_new_file(name + ".pub", key.public_line(), 0644);
  if (!why.empty()) {
    complain("plc sign", why, "another name; a key that is there is never replaced");
    return kExitUsage;
  }
  std::cout << fmt::format(
      "{0}.key signs: keep it where nobody else reads it\n{0}.pub is for plants: keys = [\"{1}.pub\"] under "
      "[engineering] in plc.toml\n",
      name, who);
  return kExitOk;
}

std::optional<std::string> read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (in) return std::string{std::istreambuf_iterator<char>(in), {}};
  complain("plc sign", fmt::format("cannot open {}: {}", path, std::strerror(errno)));
  return std::nullopt;
}

int sign(const Sign& sign) {
  const auto text = read(sign.key);
  const auto image = text ? read(sign.image) : std::nullopt;
  if (!image) return kExitUsage;
  const auto key = engineering::read_secret_key(*text, sign.key);
  if (!key) return complain(key.error()), kExitErrors;
  const std::string to = sign.output.empty() ? sign.image + ".sig" : sign.output;
  const std::string signature = engineering::sign(*key, *image) + "\n";
  if (to == "-") {
    std::cout << signature;
    return kExitOk;
  }
  std::string why;
  if (write_file(to, signature, why)) return kExitOk;
  complain("plc sign", fmt::format("cannot write {}: {}", to, why));
  return kExitUsage;
}

}  // namespace

void add_sign(Command program) {
  static Sign sign_options;
  const Command command = program.sub(
      "sign",
      "Signs an image by Ed25519. A plant with keys under [engineering] in its plc.toml takes uploads that one of them "
      "has "
      "signed, and no others.\n"
      "\n"
      "Examples:\n"
      "  plc sign --make-key anna               anna.key, which is secret, and anna.pub, for plants\n"
      "  plc sign plant.pbc --key anna.key      plant.pbc.sig, which plc remote URL upload plant.pbc finds");
  const Flag image = command.option("IMAGE", sign_options.image, "image made by plc compile");
  const Flag key = command.option("--key=NAME.key", sign_options.key, "the secret key").needs(image);
  const Flag make_key =
      command.option("--make-key=NAME", sign_options.make_key, "makes NAME.key and NAME.pub; neither may be there");
  make_key.excludes({image, key});
  command.option("-o,--output=FILE", sign_options.output, "where the signature goes, - for stdout; default: IMAGE.sig");
  command.on_run([image, key, make_key] {
    if (make_key.given()) return make(sign_options.make_key);
    if (image.given() && key.given()) return sign(sign_options);
    complain("plc sign", "say what is to be signed, and with which key",
             "plc sign IMAGE --key NAME.key, or --make-key NAME");
    return kExitUsage;
  });
}

}  // namespace plc::tools
