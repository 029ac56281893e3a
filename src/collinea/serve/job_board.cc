// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/job_board.h"

#include <algorithm>
#include <exception>

#include "collinea/report/error_text.h"

namespace collinea {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Boards of different servers differ by when they were made; a number that JSON's readers keep exactly (below 2^53).
std::uint64_t microseconds_of_clock() {
  const auto since_epoch = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(since_epoch).count());
}

}  // namespace

JobBoard::JobBoard(Work work, Run run)
    : work_(std::move(work)),
      run_(std::move(run)),
      board_(microseconds_of_clock()),
      worker_([this](std::stop_token end) { work_on(std::move(end)); }) {}

JobBoard::~JobBoard() {
  worker_.request_stop();
  const std::lock_guard lock(mutex_);
  for (auto& [id, job] : jobs_) job.stop.request_stop();
}

std::optional<std::uint64_t> JobBoard::add(JobRequest request) {
  const std::lock_guard lock(mutex_);
  const auto waiting = std::count_if(jobs_.begin(), jobs_.end(),
                                     [](const auto& job) { return job.second.status.state == JobState::kQueued; });
  if (static_cast<std::size_t>(waiting) >= kMostWaiting) return std::nullopt;
  forget_old();
  const std::uint64_t id = ++last_job_;
  Job& job = jobs_[id];
  job.status.id = id;
  job.status.changed = ++last_change_;
  job.status.project = request.project.id;
  job.status.project_name = request.project.name;
  job.status.step = request.step;
  job.request = std::move(request);
  something_to_do_.notify_all();
  return id;
}

bool JobBoard::stop(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || found->second.status.over()) return false;
  Job& job = found->second;
  job.stop.request_stop();
  if (job.status.state == JobState::kQueued) {
    job.status.state = JobState::kStopped;
    job.status.changed = ++last_change_;
  }
  return true;
}

JobChanges JobBoard::since(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  JobChanges changes{board_, last_change_, {}, {}};
  for (const auto& [id, job] : jobs_) {
    if (job.status.changed <= number) continue;
    changes.jobs.push_back(job.status);
    if (job.status.state == JobState::kRunning) changes.jobs.back().elapsed_s = seconds_since(job.began);
  }
  const auto first = std::upper_bound(lines_.begin(), lines_.end(), number,
                                      [](std::uint64_t after, const JobLine& line) { return after < line.number; });
  changes.lines.assign(first, lines_.end());
  return changes;
}

void JobBoard::work_on(std::stop_token end) {
  while (true) {
    Job* job = nullptr;
    {
      std::unique_lock lock(mutex_);
      const auto next = [&] {
        return std::find_if(jobs_.begin(), jobs_.end(),
                            [](const auto& one) { return one.second.status.state == JobState::kQueued; });
      };
      if (!something_to_do_.wait(lock, end, [&] { return next() != jobs_.end(); }) || end.stop_requested()) return;
      job = &next()->second;  // stays where it is: only those that are over are forgotten
      job->status.state = JobState::kRunning;
      job->status.changed = ++last_change_;
      job->began = job->stage_began = Clock::now();
    }
    do_job(*job);
  }
}

void JobBoard::do_job(Job& job) {
  Run run = run_;
  run.stop = job.stop.get_token();
  run.progress = [this, &job](std::string_view stage, double done) {
    progress(job, stage, done);
    run_.report(stage, done);
  };
  run.log = [this, &job](std::string_view line) { say(job, line); };
  Result<std::string> outcome;
  try {
    outcome = work_(job.request, run);
  } catch (const std::exception& error) {  // the server goes on: other jobs are not to suffer
    outcome = fail(Errc::kUnsupported, std::string("defect in the program: ") + error.what());
  } catch (...) {
    outcome = fail(Errc::kUnsupported, "defect in the program");
  }
  const std::string failure = outcome ? "" : text_of(outcome.error(), run.spelling);
  if (!outcome) say(job, failure);
  const std::lock_guard lock(mutex_);
  JobStatus& status = job.status;
  status.state = outcome                                    ? JobState::kDone
                 : outcome.error().code == Errc::kCancelled ? JobState::kStopped
                                                            : JobState::kFailed;
  if (outcome)
    status.findings = *std::move(outcome);
  else
    status.error = failure;
  status.left_s.reset();
  status.elapsed_s = seconds_since(job.began);
  status.changed = ++last_change_;
}

void JobBoard::progress(Job& job, std::string_view stage, double done) {
  constexpr double kEnoughToSay = 0.01;
  const std::lock_guard lock(mutex_);
  JobStatus& status = job.status;
  if (status.stage != stage) {
    status.stage = stage;
    job.stage_began = Clock::now();
  }
  const double stage_s = seconds_since(job.stage_began);
  status.done = std::clamp(done, 0.0, 1.0);
  status.left_s = done > kEnoughToSay ? std::optional(stage_s * (1 - status.done) / done) : std::nullopt;
  status.changed = ++last_change_;
}

void JobBoard::say(Job& job, std::string_view line) {
  line = line.substr(0, kLongestLine);
  {
    const std::lock_guard lock(mutex_);
    lines_.push_back({++last_change_, job.status.id, std::string(line)});
    if (lines_.size() > kMostLines) lines_.pop_front();
  }
  run_.say(line);
}

// The oldest of those that are over. The caller holds the mutex.
void JobBoard::forget_old() {
  for (auto job = jobs_.begin(); job != jobs_.end() && jobs_.size() >= kMostJobs;)
    job = job->second.status.over() ? jobs_.erase(job) : std::next(job);
}

}  // namespace collinea
