// A day of a historian, simulated: how large it is, how fast it is written, and how long any zoom of any tag takes.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <random>
#include <stdexcept>
#include <vector>

#include "bench/measurements.h"
#include "bench/scratch.h"
#include "core/clock.h"
#include "historian/history_file.h"
#include "historian/history_reader.h"

namespace plc::bench {
namespace {

using historian::kSecond;

constexpr core::TimeNs kBegin = 1'800'000'000 * kSecond;
constexpr core::TimeNs kPeriod = kSecond / 10;
constexpr std::size_t kPoints = 1000;

/// A number that looks random, of a tag and a sample.
std::uint64_t mixed(std::uint64_t tag, std::uint64_t sample) {
  std::uint64_t x = (tag << 40) + sample + 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// Of ten tags three are measured values with noise in every bit, three come from a converter of 12 bits, one rests,
/// two are counters, one is a BOOL.
float measured(std::uint64_t tag, std::uint64_t sample) {
  const double seconds = static_cast<double>(sample) / 10;
  const double slow = 50 + 40 * std::sin(seconds / (600 + static_cast<double>(tag)));
  const double noise = static_cast<double>(mixed(tag, sample) & 0xffffff) / 0x1000000 - 0.5;
  switch (tag % 10) {
    case 0:
    case 1:
    case 2:
      return static_cast<float>(slow + noise);
    case 6:
      return 20.5F;
    default:
      return static_cast<float>(std::round((slow + noise) * 40.95) / 40.95);
  }
}

bool is_real(std::uint64_t tag) { return tag % 10 < 7; }

double value_of(std::uint64_t tag, std::uint64_t sample) {
  if (is_real(tag)) return static_cast<double>(measured(tag, sample));
  if (tag % 10 < 9) return static_cast<double>(static_cast<std::int32_t>(sample / (tag % 7 + 1)));
  return mixed(tag, sample / 300) % 2 == 0 ? 0 : 1;
}

std::vector<historian::Tag> tags(std::uint32_t count) {
  std::vector<historian::Tag> all;
  for (std::uint32_t i = 0; i < count; ++i) {
    const core::TypeId type = is_real(i) ? core::TypeId::kReal : i % 10 < 9 ? core::TypeId::kDint : core::TypeId::kBool;
    all.push_back({fmt::format("Tag{}", i), type});
  }
  return all;
}

void write(historian::HistoryFile& file, std::uint64_t samples) {
  for (std::uint64_t sample = 0; sample < samples; ++sample) {
    file.add(kBegin + static_cast<core::TimeNs>(sample) * kPeriod, [sample](std::size_t tag, std::byte* to) {
      if (is_real(tag)) {
        const float value = measured(tag, sample);
        std::memcpy(to, &value, sizeof value);
      } else if (tag % 10 < 9) {
        const auto value = static_cast<std::int32_t>(value_of(tag, sample));
        std::memcpy(to, &value, sizeof value);
      } else {
        *to = static_cast<std::byte>(value_of(tag, sample));
      }
    });
  }
  file.flush();
}

/// Whether a course says what the samples are: of each point with few samples all of them are looked at.
bool is_right(const historian::Course& course, std::uint64_t tag, std::uint64_t samples) {
  if (course.points.empty()) return false;
  for (std::size_t i = 0; i < course.points.size(); i += 37) {
    const historian::Point& point = course.points[i];
    const auto first = (point.us * 1000 - kBegin + kPeriod - 1) / kPeriod;
    if (course.step_ns == 0) {
      if (point.summary.least != value_of(tag, static_cast<std::uint64_t>(first))) return false;
      continue;
    }
    // Summaries begin where their 10 s, 5 min .. do: what they hold lies within a step of the point.
    const auto room = course.step_ns / kPeriod + 3000;
    historian::Summary around;
    for (auto sample = std::max<std::int64_t>(0, first - room);
         sample < std::min<std::int64_t>(first + 2 * room, static_cast<std::int64_t>(samples)); ++sample) {
      around.add(value_of(tag, static_cast<std::uint64_t>(sample)));
    }
    if (point.summary.least < around.least || point.summary.greatest > around.greatest) return false;
  }
  return true;
}

/// What the system has of the file in memory is forgotten, as far as that can be.
void forget(const std::string& path) {
  for (const char* const end : {"", "-wal"}) {
    const int file = ::open((path + end).c_str(), O_RDONLY);
    if (file < 0) continue;
    ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
    ::close(file);
  }
}

struct Zooms {
  std::vector<double> ms;
  bool right = true;
};

Zooms zoom(const historian::HistoryFile& file, std::uint64_t samples, std::uint32_t count, bool cold) {
  historian::HistoryReader reader(file);
  const core::MonotonicClock clock;
  std::mt19937_64 random(5);
  const core::TimeNs whole = static_cast<core::TimeNs>(samples) * kPeriod;
  Zooms zooms;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t tag = random() % file.tags().size();
    // From ten seconds to all of it, each factor as often as the other.
    const double share = std::exp(-static_cast<double>(random() % 1000) / 1000 *
                                  std::log(std::max(1.0, static_cast<double>(whole) / (10.0 * kSecond))));
    const auto span = static_cast<core::TimeNs>(share * static_cast<double>(whole));
    const core::TimeNs from =
        kBegin + static_cast<core::TimeNs>(random() % static_cast<std::uint64_t>(whole - span + 1));
    if (cold) forget(file.path());
    const core::TimeNs begin = clock.now_ns();
    const auto course = reader.read(file.tags()[tag].path, from, from + span, kPoints);
    zooms.ms.push_back(static_cast<double>(clock.now_ns() - begin) / 1e6);
    zooms.right = zooms.right && course && is_right(*course, tag, samples);
  }
  return zooms;
}

}  // namespace

Verdict measure_historian(const HistorianPlan& plan) {
  Verdict verdict;
  const bool check_only = plan.hours == 0;
  const std::uint32_t count = check_only ? 20 : plan.tags;
  const std::uint64_t samples = check_only ? 10 * 3600 * 6 : std::uint64_t{plan.hours} * 3600 * 10;
  const Scratch scratch;
  historian::HistoryFile file(scratch.file("history.db"), tags(count), 3650, std::uint64_t{1} << 50);
  const core::MonotonicClock clock;
  const core::TimeNs begin = clock.now_ns();
  write(file, samples);
  const double seconds = static_cast<double>(clock.now_ns() - begin) / 1e9;
  if (const std::string said = file.take_said(); !said.empty()) throw std::runtime_error(said);
  const Zooms warm = zoom(file, samples, check_only ? 50 : 500, false);
  const Zooms cold = zoom(file, samples, check_only ? 10 : 200, true);
  verdict.correct = warm.right && cold.right;
  std::cout << fmt::format("  {} tags, {} samples of each: {}\n", count, samples,
                           verdict.correct ? "results right" : "RESULTS WRONG");
  if (check_only || !verdict.correct) return verdict;
  const double gigabytes = static_cast<double>(std::filesystem::file_size(file.path())) / 1e9;
  const double all = static_cast<double>(samples) * count;
  const double share = 100 * seconds / (static_cast<double>(samples) / 10);
  const auto most = [](const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); };
  std::cout << fmt::format("  size: {:.2f} GB, {:.2f} bytes a sample, {}\n", gigabytes, gigabytes * 1e9 / all,
                           limit_text(gigabytes, limit::kHistorySize, verdict));
  std::cout << fmt::format("  written in {:.0f} s, simulation included: {:.2f} % of a processor in real time\n",
                           seconds, share);
  std::cout << fmt::format("  {} zooms of {} points, of 10 s to all of it: median {:.2f} ms, longest {:.1f} ms, {}\n",
                           warm.ms.size(), kPoints, median(warm.ms), most(warm.ms),
                           limit_text(most(warm.ms), limit::kHistoryZoom, verdict));
  std::cout << fmt::format("  {} zooms with nothing of the file in memory: median {:.2f} ms, longest {:.1f} ms, {}\n",
                           cold.ms.size(), median(cold.ms), most(cold.ms),
                           limit_text(most(cold.ms), limit::kHistoryZoomCold, verdict));
  return verdict;
}

}  // namespace plc::bench
