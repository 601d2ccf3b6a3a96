// The certificate of the engineering server: made once, or read from files.
#include "engineering/certificate.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "core/diagnostics.h"
#include "tests/support/run_tool.h"
#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

TEST(Certificate, IsMadeOnceAndKept) {
  const ScratchFolder scratch;
  SetCalendar calendar;
  const auto first = engineering::own_certificate(scratch.file("kept"), {"plant"}, calendar.now_ns);
  const auto second = engineering::own_certificate(scratch.file("kept"), {"plant"}, calendar.now_ns);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->fingerprint, second->fingerprint);
  EXPECT_FALSE(second->made);
  const core::TimeNs years = core::TimeNs{10} * 365 * 86'400 * 1'000'000'000;
  const auto later = engineering::own_certificate(scratch.file("kept"), {"plant"}, calendar.now_ns + years);
  ASSERT_TRUE(later);
  EXPECT_TRUE(later->made) << "it has ended";
}

TEST(Certificate, OneThatDoesNotFitIsSaid) {
  const ScratchFolder scratch;
  SetCalendar calendar;
  const auto a = engineering::own_certificate(scratch.file("a"), {"a"}, calendar.now_ns);
  const auto b = engineering::own_certificate(scratch.file("b"), {"b"}, calendar.now_ns);
  ASSERT_TRUE(a && b);
  std::ofstream(scratch.file("text")) << "no PEM";
  const auto code = [&](const std::string& chain, const std::string& key) {
    const auto read = engineering::read_certificate(scratch.file(chain), scratch.file(key));
    return read ? std::string("good") : std::string(core::info(read.error().code).name);
  };
  EXPECT_EQ(code("a/certificate.pem", "a/key.pem"), "good");
  EXPECT_EQ(code("a/certificate.pem", "b/key.pem"), "P7703");
  EXPECT_EQ(code("text", "a/key.pem"), "P7703");
  EXPECT_EQ(code("a/certificate.pem", "text"), "P7703");
  EXPECT_EQ(code("nowhere", "a/key.pem"), "P7703");
}

}  // namespace
}  // namespace plc::test
