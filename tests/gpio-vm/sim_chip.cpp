#include "tests/gpio-vm/sim_chip.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>
#include <utility>

namespace plc::test {
namespace {

namespace fs = std::filesystem;
const std::string kSim = "/sys/kernel/config/gpio-sim/";
const std::string kTracing = "/sys/kernel/tracing/";

[[noreturn]] void fail(const std::string& what) {
  std::cerr << what << ": " << std::strerror(errno) << std::endl;
  std::abort();
}

}  // namespace

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

void write_text(const std::string& path, const std::string& text) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_TRUNC | O_CREAT, 0644);
  if (fd < 0 || ::write(fd, text.data(), text.size()) != static_cast<ssize_t>(text.size())) fail("write " + path);
  ::close(fd);
}

SimChip::SimChip(std::string label, const Options& options) : label_(std::move(label)), folder_(kSim + label_) {
  fs::create_directories(folder_ + "/bank0");
  write_text(folder_ + "/bank0/num_lines", std::to_string(options.lines));
  write_text(folder_ + "/bank0/label", label_);
  for (const auto& [line, name] : options.names) {
    fs::create_directories(folder_ + "/bank0/line" + std::to_string(line));
    write_text(folder_ + "/bank0/line" + std::to_string(line) + "/name", name);
  }
  for (const auto& [line, consumer] : options.hogs) {
    const std::string hog = folder_ + "/bank0/line" + std::to_string(line) + "/hog";
    fs::create_directories(hog);
    write_text(hog + "/name", consumer);
    write_text(hog + "/direction", "input");
  }
  plug();
}

SimChip::~SimChip() {
  unplug();
  // configfs: innermost folders first, and only rmdir.
  for (const auto& line : fs::directory_iterator(folder_ + "/bank0")) {
    if (!line.is_directory()) continue;
    ::rmdir((line.path() / "hog").c_str());
    ::rmdir(line.path().c_str());
  }
  ::rmdir((folder_ + "/bank0").c_str());
  ::rmdir(folder_.c_str());
}

void SimChip::plug() {
  write_text(folder_ + "/live", "1");
  name_ = text_of(folder_ + "/bank0/chip_name");
  const std::string device = "/sys/devices/platform/" + text_of(folder_ + "/dev_name");
  sysfs_ = device + "/" + name_;
  for (const auto& entry : fs::directory_iterator(device + "/gpio"))
    base_ = std::atoi(text_of(entry.path() / "base").c_str());
}

void SimChip::unplug() { write_text(folder_ + "/live", "0"); }

std::string SimChip::attribute(int line, const char* what) const {
  return sysfs_ + "/sim_gpio" + std::to_string(line) + "/" + what;
}

void SimChip::pull(int line, bool up) const { write_text(attribute(line, "pull"), up ? "pull-up" : "pull-down"); }

bool SimChip::value(int line) const {
  const std::string text = text_of(attribute(line, "value"));
  if (text != "0" && text != "1") fail("read " + attribute(line, "value"));
  return text == "1";
}

KernelTrace::KernelTrace() { write_text(kTracing + "trace", ""); }

std::vector<KernelTrace::Set> KernelTrace::sets(int number) const {
  // "    plc-guardian-123     [000] d..1.    12.345678: gpio_value: 496 set 1"
  std::vector<Set> found;
  std::istringstream lines(text_of(kTracing + "trace"));
  const std::string wanted = "gpio_value: " + std::to_string(number) + " set ";
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find(wanted);
    if (at == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(' ');
    found.push_back({line.substr(begin, line.rfind('-', line.find('[')) - begin), line[at + wanted.size()] - '0'});
  }
  return found;
}

}  // namespace plc::test
