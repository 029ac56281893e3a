// SPDX-License-Identifier: Apache-2.0
// Edits of several processes, and of one that is killed.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <map>
#include <set>
#include <thread>

#include "collinea/base/file.h"
#include "collinea/edit/make_edits.h"
#include "collinea/edit/test_edits.h"

namespace collinea {
namespace {

constexpr const char* kImages[] = {"photo 0.jpg", "photo 1.jpg", "photo 2.jpg", "photo 3.jpg"};

// Marks, with its number as the standard deviation, and says each on the pipe once it is made.
[[noreturn]] void edit_for_ever(const std::filesystem::path& project, int pipe, int first, int most) {
  Journal journal(project);
  for (int i = first; i < first + most; ++i) {
    const std::vector<Edit> edits = {
        parse_edit(std::vector<std::string>{"mark", "B", kImages[i % 4], "1", "2", std::to_string(i)}).value()};
    const auto made = make_edits(project, journal, edits);
    if (!made || ::write(pipe, &i, sizeof i) != sizeof i) ::_exit(1);
  }
  ::_exit(0);
}

struct Child {
  pid_t id = 0;
  int pipe = 0;
};

Child start(const std::filesystem::path& project, int first, int most) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t id = ::fork();
  if (id == 0) edit_for_ever(project, ends[1], first, most);
  ::close(ends[1]);
  return {id, ends[0]};
}

// The last number that was said; the pipe is closed.
int last_said(const Child& child, int before) {
  int value = before, read = before;
  while (::read(child.pipe, &read, sizeof read) == sizeof read) value = read;
  ::close(child.pipe);
  return value;
}

class EditsAtOnce : public EditsTest {
 protected:
  [[nodiscard]] std::multiset<int> marked() {
    EXPECT_TRUE(journal_.refresh());
    std::multiset<int> all;
    for (const EditEntry& entry : journal_.history().entries())
      all.insert(static_cast<int>(*std::get<MarkPoint>(entry.edit).sigma_px));
    return all;
  }
};

TEST_F(EditsAtOnce, OfTwoProcessesNoneIsLost) {
  constexpr int kMost = 30;
  const Child one = start(project(), 1, kMost), other = start(project(), 1000, kMost);
  EXPECT_EQ(last_said(one, 0), kMost);
  EXPECT_EQ(last_said(other, 0), 1000 + kMost - 1);
  for (const Child& child : {one, other}) {
    int status = 0;
    ASSERT_EQ(::waitpid(child.id, &status, 0), child.id);
    EXPECT_EQ(status, 0);
  }
  const std::multiset<int> all = marked();
  EXPECT_EQ(all.size(), std::size_t{2 * kMost});
  for (int i = 0; i < kMost; ++i) EXPECT_TRUE(all.contains(1 + i) && all.contains(1000 + i)) << i;
  auto opened = store();
  ASSERT_TRUE(apply_edits(opened, journal_));
  EXPECT_EQ(opened.last_edit(), journal_.number());
}

// A program that edits is killed at random moments: what it said that it made is there, and one more at most; journal
// and database agree once the project is opened for work.
TEST_F(EditsAtOnce, OfAProgramThatIsKilledAtMostTheEditUnderTheHandIsLost) {
  constexpr int kTimes = 50;
  Random random(5);
  int last = 0;
  std::size_t entries = 0;
  for (int time = 0; time < kTimes; ++time) {
    const Child child = start(project(), last + 1, 1 << 20);
    int first = last;
    ASSERT_EQ(::read(child.pipe, &first, sizeof first), static_cast<ssize_t>(sizeof first));  // it is at work
    std::this_thread::sleep_for(std::chrono::microseconds(random.below(20'000)));
    ASSERT_EQ(::kill(child.id, SIGKILL), 0);
    int status = 0;
    ASSERT_EQ(::waitpid(child.id, &status, 0), child.id);
    ASSERT_TRUE(WIFSIGNALED(status));
    const int said = last_said(child, first);
    auto opened = store();
    const auto unfit = apply_edits(opened, journal_);
    ASSERT_TRUE(unfit) << unfit.error().message;
    EXPECT_TRUE(unfit->empty());
    EXPECT_EQ(opened.last_edit(), journal_.number());
    const std::multiset<int> all = marked();
    for (int i = last + 1; i <= said; ++i) EXPECT_TRUE(all.contains(i)) << i;
    const std::size_t made = static_cast<std::size_t>(said - last);
    EXPECT_GE(all.size(), entries + made);
    EXPECT_LE(all.size(), entries + made + 1);
    entries = all.size();
    last = *all.rbegin();
    // The database holds the last mark of each image.
    std::map<std::string, double> newest;
    for (const EditEntry& entry : journal_.history().entries()) {
      const auto& mark = std::get<MarkPoint>(entry.edit);
      newest[mark.image] = *mark.sigma_px;
    }
    const Block block = opened.read_setup().value();
    for (const ControlObservation& seen : block.control_observations) {
      const auto found = newest.find(block.images.at(seen.image).file);
      if (seen.point.value == 1 && found != newest.end()) EXPECT_EQ(seen.sigma_px, found->second);
    }
  }
}

}  // namespace
}  // namespace collinea
