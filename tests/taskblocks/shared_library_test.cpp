// Which shared objects are loaded, and what is said of those that are not.
#include "taskblocks/shared_library.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <limits>

#include "core/floating_point.h"
#include "tests/taskblocks/libraries.h"

namespace plc::test {
namespace {

using std::chrono::milliseconds;
using taskblocks::load_shared_library;
using taskblocks::Registry;

/// The words of the refusal, after which the registry must be as it was.
std::string refusal(const std::string& path, milliseconds time = taskblocks::kTrialTime) {
  Registry registry = Registry::built_in();
  const std::size_t before = registry.entries().size();
  const auto problem = load_shared_library(path, registry, time);
  if (!problem) return "it was loaded";
  EXPECT_EQ(registry.entries().size(), before);
  EXPECT_EQ(problem->code, core::Code::P7801);
  EXPECT_FALSE(problem->help.empty()) << problem->message;
  return problem->message;
}

class SharedLibrary : public ::testing::Test {
 protected:
  void expect_refused(const std::string& name, const std::string& why, milliseconds time = taskblocks::kTrialTime) {
    const std::string path = installed(scratch, name);
    const std::string said = refusal(path, time);
    EXPECT_NE(said.find(path + ": "), std::string::npos) << said;
    EXPECT_NE(said.find(why), std::string::npos) << said;
  }
  ScratchFolder scratch;
};

TEST_F(SharedLibrary, AddsItsBlocks) {
  Registry registry = Registry::built_in();
  const std::string path = installed(scratch, "good");
  const auto problem = load_shared_library(path, registry);
  ASSERT_FALSE(problem) << problem->message;
  const Registry::Entry* const block = registry.find("Faulty");
  ASSERT_NE(block, nullptr);
  EXPECT_EQ(block->source, std::filesystem::canonical(path).string());
  EXPECT_EQ(std::string(block->library->name), "good");
  EXPECT_EQ(block->block->port_count, 2u);
  ASSERT_TRUE(load_shared_library(path, registry)) << "its names are taken";
}

/// Half of the smallest number that is no subnormal one: 0 for a thread that takes those for zero.
double half_of_the_smallest() {
  volatile double smallest = std::numeric_limits<double>::min();
  return smallest / 2;
}

TEST_F(SharedLibrary, ChangesNothingOfHowOthersCompute) {
  const std::string path = installed(scratch, "fast_math");
  void* const raw = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  ASSERT_NE(raw, nullptr) << ::dlerror();
  const double loaded = half_of_the_smallest();
  ::dlclose(raw);
  core::set_floating_point_mode();
  if (loaded != 0) GTEST_SKIP() << "-ffast-math of this compiler changes no modes";
  Registry registry;
  const auto problem = load_shared_library(path, registry);
  ASSERT_FALSE(problem) << problem->message;
  EXPECT_GT(half_of_the_smallest(), 0);
}

TEST_F(SharedLibrary, TwoWithClassesOfTheSameNamesKeepThemApart) {
  Registry registry;
  for (const char* name : {"same_names_1", "same_names_2"}) {
    const auto problem = load_shared_library(installed(scratch, name), registry);
    ASSERT_FALSE(problem) << problem->message;
  }
  ASSERT_NE(registry.find("FILTER_1"), nullptr);
  ASSERT_NE(registry.find("FILTER_2"), nullptr);
  EXPECT_EQ(std::string(registry.find("FILTER_1")->block->ports[0].type->name), "POINT_2");
  EXPECT_EQ(std::string(registry.find("FILTER_2")->block->ports[0].type->name), "POINT_3");
  EXPECT_EQ(registry.find("FILTER_2")->block->ports[0].type->field_count, 3u);
}

TEST_F(SharedLibrary, IsNotThere) {
  EXPECT_NE(refusal(scratch.file("nothing.so")).find("No such file"), std::string::npos);
  EXPECT_NE(refusal(scratch.file("")).find("it is no file"), std::string::npos) << "a folder";
}

TEST_F(SharedLibrary, IsNoLibrary) {
  std::ofstream(scratch.file("text.so")) << "not a library\n";
  ::chmod(scratch.file("text.so").c_str(), 0644);
  EXPECT_NE(refusal(scratch.file("text.so")).find("text.so: "), std::string::npos);
  expect_refused("undefined_symbol", "undefined symbol: nobody_has_this");
}

TEST_F(SharedLibrary, HasNoDescription) { expect_refused("missing_symbol", "it has no function picard_library_v1()"); }

TEST_F(SharedLibrary, SpeaksAnotherVersion) {
  expect_refused("wrong_abi", "it speaks version 3 of the taskblock interface, this program version 2");
}

TEST_F(SharedLibrary, HasAConstructorThatThrows) {
  expect_refused("throwing_constructor", "a constructor failed: no such device");
}

TEST_F(SharedLibrary, HasAConstructorThatCrashes) {
  expect_refused("crashing_constructor", "it crashed while it described its blocks: signal 11");
}

TEST_F(SharedLibrary, HasStaticObjectsThatFail) {
  expect_refused("throwing_initialiser", "it crashed while it was loaded: signal 6");
  expect_refused("crashing_initialiser", "it crashed while it was loaded: signal 11");
  expect_refused("leaving_initialiser", "it ended the process while it was loaded, with exit code 0");
}

TEST_F(SharedLibrary, NeverComesToAnEnd) {
  const auto begin = std::chrono::steady_clock::now();
  expect_refused("hanging_initialiser", "it came to no end within 300 ms, while it was loaded", milliseconds(300));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST_F(SharedLibrary, CouldHaveBeenWrittenByOthers) {
  const std::string path = installed(scratch, "good");
  ::chmod(path.c_str(), 0775);
  EXPECT_NE(refusal(path).find("it may be written by its group"), std::string::npos) << refusal(path);
  ::chmod(path.c_str(), 0757);
  EXPECT_NE(refusal(path).find("it may be written by everybody"), std::string::npos) << refusal(path);
  ::chmod(path.c_str(), 0755);
  EXPECT_EQ(refusal(path), "it was loaded") << "the folders of this test are fit";
}

TEST_F(SharedLibrary, LiesInAFolderThatOthersCanWrite) {
  std::filesystem::create_directories(scratch.file("outer/inner"));
  const std::string path = scratch.file("outer/inner/good.so");
  std::filesystem::copy_file(installed(scratch, "good"), path);
  const std::string outer = scratch.file("outer"), inner = scratch.file("outer/inner");
  const auto modes = [&](mode_t outer_mode, mode_t inner_mode) {
    ::chmod(path.c_str(), 0755);
    ::chmod(outer.c_str(), outer_mode);
    ::chmod(inner.c_str(), inner_mode);
    return refusal(path);
  };
  EXPECT_EQ(modes(0755, 0755), "it was loaded");
  EXPECT_NE(modes(0755, 0777).find("inner may be written by everybody"), std::string::npos);
  EXPECT_NE(modes(0775, 0755).find("outer may be written by its group"), std::string::npos);
  EXPECT_EQ(modes(01777, 0755), "it was loaded") << "as in /tmp, nobody can replace the folder of another";
  EXPECT_NE(modes(0755, 01777).find("inner may be written by everybody"), std::string::npos)
      << "what it needs might be put beside it";
  // A link leads to the place that counts.
  std::filesystem::create_symlink(inner, scratch.file("link"));
  EXPECT_NE(refusal(scratch.file("link/good.so")).find("inner may be written by everybody"), std::string::npos);
}

TEST_F(SharedLibrary, BelongsToSomebodyElse) {
  const std::string path = installed(scratch, "good");
  if (::chown(path.c_str(), 12345, static_cast<gid_t>(-1)) != 0) GTEST_SKIP() << "only root gives files away";
  EXPECT_NE(refusal(path).find("it belongs to user 12345"), std::string::npos) << refusal(path);
}

std::string maps() {
  std::ifstream in("/proc/self/maps");
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_F(SharedLibrary, IsLoadedFromACopy) {
  const std::string path = installed(scratch, "good");
  Registry registry;
  ASSERT_FALSE(load_shared_library(path, registry));
  EXPECT_EQ(maps().find(path), std::string::npos);
  EXPECT_NE(maps().find("/memfd:good.so"), std::string::npos);
  // As `cp` does: the same file, cut and written anew.
  std::ofstream(path, std::ios::trunc) << "something else";
  EXPECT_EQ(std::string(registry.find("FAULTY")->library->name), "good");
}

/// good.cpp with a function of libhelp.so, which lies in a folder `deps` beside it.
class NeedsAnother : public SharedLibrary {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(scratch.file("deps"));
    write_text(scratch.file("help.cpp"), "int help_of_another() { return 7; }\n");
    write_text(scratch.file("needy.cpp"),
               "int help_of_another();\nint needs = help_of_another();\n#include \"" PLC_FAULTY_SOURCES
               "/good.cpp\"\n");
    make("help.cpp", "deps/libhelp.so", "-Wl,-soname,libhelp.so");
  }
  void make(const std::string& source, const std::string& to, const std::string& flags) const {
    const auto result =
        run_tool({PLC_CXX, "-std=c++20", "-shared", "-fPIC", "-I", PLC_SOURCES, "-I", PLC_SOURCES "/taskblocks/include",
                  "-I", PLC_FAULTY_SOURCES, scratch.file(source), "-o", scratch.file(to), "-L" + scratch.file("deps"),
                  flags, "-Wl,--enable-new-dtags", source == "needy.cpp" ? "-lhelp" : "-lm"});
    ASSERT_EQ(result.code, 0) << result.all();
    ::chmod(scratch.file(to).c_str(), 0755);
  }
};

TEST_F(NeedsAnother, WhichIsCheckedAndCopiedToo) {
  make("needy.cpp", "needy.so", "-Wl,-rpath,$ORIGIN/deps");
  const std::string library = scratch.file("needy.so"), help = scratch.file("deps/libhelp.so");
  ::chmod(scratch.file("deps").c_str(), 0777);
  EXPECT_NE(refusal(library).find("the folder " + scratch.file("deps") + " may be written by everybody"),
            std::string::npos)
      << refusal(library);
  ::chmod(scratch.file("deps").c_str(), 0755);
  ::chmod(help.c_str(), 0757);
  EXPECT_NE(refusal(library).find("what it needs, " + help + ", may be written by everybody"), std::string::npos)
      << refusal(library);
  ::chmod(help.c_str(), 0755);
  Registry registry;
  const auto problem = load_shared_library(library, registry);
  ASSERT_FALSE(problem) << problem->message;
  EXPECT_EQ(maps().find(help), std::string::npos);
  EXPECT_NE(maps().find("/memfd:libhelp.so"), std::string::npos);
}

TEST_F(NeedsAnother, FromAFolderThatSomebodyElseCouldMake) {
  const std::string nobodys = (std::filesystem::temp_directory_path() / "plc-nobody-has-made-this").string();
  make("needy.cpp", "needy.so", "-Wl,-rpath," + nobodys + ":$ORIGIN/deps");
  EXPECT_NE(refusal(scratch.file("needy.so")).find("may be written by everybody"), std::string::npos)
      << refusal(scratch.file("needy.so"));
}

TEST_F(NeedsAnother, FromWhereverTheProgramIsStarted) {
  make("needy.cpp", "needy.so", "-Wl,-rpath,deps");
  EXPECT_NE(refusal(scratch.file("needy.so")).find("looks for libraries in \"deps\""), std::string::npos)
      << refusal(scratch.file("needy.so"));
}

}  // namespace
}  // namespace plc::test
