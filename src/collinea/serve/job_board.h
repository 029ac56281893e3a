// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/serve/project_files.h"
#include "collinea/steps/step_list.h"

namespace collinea {

/// What is asked for: everything up to and including a step.
struct JobRequest {
  ServedProject project;
  Step step = Step::kReport;
  std::string options = "{}";  ///< that change, as changed_settings() takes them
};

enum class JobState : std::uint8_t { kQueued, kRunning, kDone, kFailed, kStopped };
inline constexpr Word<JobState> kJobStateWords[] = {{JobState::kQueued, "queued"},
                                                    {JobState::kRunning, "running"},
                                                    {JobState::kDone, "done"},
                                                    {JobState::kFailed, "failed"},
                                                    {JobState::kStopped, "stopped"}};
[[nodiscard]] constexpr std::span<const Word<JobState>> words(JobState) { return kJobStateWords; }

/// How a job stands.
struct JobStatus {
  std::uint64_t id = 0;
  std::uint64_t changed = 0;  ///< number of its last change
  std::string project, project_name;
  Step step{};
  JobState state = JobState::kQueued;
  std::string stage;             ///< of its progress
  double done = 0;               ///< of the stage, in [0, 1]
  double elapsed_s = 0;          ///< since the job began
  std::optional<double> left_s;  ///< of the stage; nothing: too early to say
  std::string error;             ///< why it failed
  std::string findings;          ///< of the steps, a JSON array; empty before the end
  [[nodiscard]] bool over() const { return state != JobState::kQueued && state != JobState::kRunning; }
};

/// A line of a job's log.
struct JobLine {
  std::uint64_t number = 0, job = 0;
  std::string text;
};

/// What changed since some number.
struct JobChanges {
  std::uint64_t board = 0;   ///< which board counts: another has another number
  std::uint64_t number = 0;  ///< of the last change
  std::vector<JobStatus> jobs;
  std::vector<JobLine> lines;
};

/// Jobs one after the other, each with all processor threads: so no project has two writers. The end of the board stops
/// the job in work and waits for it.
class JobBoard {
 public:
  /// Does a job; the findings of its steps as a JSON array.
  using Work = std::function<Result<std::string>(const JobRequest&, const Run&)>;

  static constexpr std::size_t kMostWaiting = 32, kMostJobs = 200, kMostLines = 5000, kLongestLine = 2000;

  /// `run`: its threads and spelling of options; its log and progress show those of every job, too.
  JobBoard(Work work, Run run);
  ~JobBoard();
  JobBoard(const JobBoard&) = delete;
  JobBoard& operator=(const JobBoard&) = delete;

  /// Its number; nothing when kMostWaiting are waiting.
  [[nodiscard]] std::optional<std::uint64_t> add(JobRequest request);
  /// One that waits is not begun, one in work stops as soon as it can. Whether it was waiting or in work.
  bool stop(std::uint64_t id);

  /// Everything of jobs that are remembered, when `number` is 0.
  [[nodiscard]] JobChanges since(std::uint64_t number) const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    JobStatus status;
    JobRequest request;
    std::stop_source stop;
    Clock::time_point began, stage_began;
  };

  void work_on(std::stop_token end);
  void do_job(Job& job);
  void progress(Job& job, std::string_view stage, double done);
  void say(Job& job, std::string_view line);
  void forget_old();

  Work work_;
  Run run_;
  mutable std::mutex mutex_;
  std::condition_variable_any something_to_do_;
  std::map<std::uint64_t, Job> jobs_;
  std::deque<JobLine> lines_;
  std::uint64_t last_job_ = 0, last_change_ = 0;
  const std::uint64_t board_;
  std::jthread worker_;  // last: it ends before what it uses
};

}  // namespace collinea
