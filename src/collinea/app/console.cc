// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/console.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <thread>

#include "collinea/app/exit_code.h"
#include "collinea/app/json_text.h"
#include "collinea/report/error_text.h"

namespace collinea {
namespace {

using Clock = std::chrono::steady_clock;

std::string time_text(double seconds) {
  if (seconds < 100) return fmt::format("{:.0f} s", seconds);
  if (seconds < 6000) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

constexpr char kSignal = 's', kQuit = 'q';
constexpr int kGrace_ms = 1500;  // so long a computation may take to notice that it shall stop

std::atomic<int> signal_pipe = -1;  // a signal handler can reach nothing but globals

void on_signal(int) {
  const int saved = errno;
  [[maybe_unused]] const auto written = ::write(signal_pipe, &kSignal, 1);
  errno = saved;
}

}  // namespace

struct Console::State {
  std::mutex mutex;
  ProgressForm show = ProgressForm::kLines;
  SpellOption spelling;
  int threads = 1;
  std::stop_source stop;
  std::thread signals;  // waits for Ctrl-C
  int wake[2] = {-1, -1};
  std::FILE* log_file = nullptr;

  std::string stage;
  Clock::time_point stage_start, last_shown;
  bool bar_on_screen = false;

  ~State() {
    clear_bar();
    if (log_file) std::fclose(log_file);
  }

  void clear_bar() {
    if (bar_on_screen) std::fputs("\r\x1b[K", stderr);
    bar_on_screen = false;
  }

  void progress(std::string_view name, double done) {
    const std::lock_guard lock(mutex);
    const auto now = Clock::now();
    if (stage != name) {
      stage = name;
      stage_start = now;
      last_shown = {};
    }
    if (done < 1 && now - last_shown < std::chrono::milliseconds(200)) return;
    last_shown = now;
    const double elapsed_s = std::chrono::duration<double>(now - stage_start).count();
    const double left_s = done > 0.01 ? elapsed_s * (1 - done) / done : -1;
    if (show == ProgressForm::kJson) {
      fmt::print(stderr, "{{\"stage\":\"{}\",\"done\":{:.4f},\"elapsed_s\":{:.1f},\"left_s\":{}}}\n",
                 json_escaped(name), done, elapsed_s, left_s < 0 ? "null" : fmt::format("{:.1f}", left_s));
    } else if (show == ProgressForm::kBar) {
      constexpr int kWidth = 32;
      const int full = std::clamp(static_cast<int>(done * kWidth + 0.5), 0, kWidth);
      fmt::print(stderr, "\r\x1b[K{:<24} [{:=<{}}{: <{}}] {:3.0f} %  {}", name, "", full, "", kWidth - full, 100 * done,
                 left_s < 0 ? "" : time_text(left_s) + " left");
      bar_on_screen = true;
    }
    std::fflush(stderr);
  }

  void say(std::string_view line) {
    const std::lock_guard lock(mutex);
    clear_bar();
    if (show == ProgressForm::kJson)
      fmt::print(stderr, "{{\"log\":\"{}\"}}\n", json_escaped(line));
    else if (show != ProgressForm::kNone)
      fmt::print(stderr, "{}\n", line);
    std::fflush(stderr);
    write_log(line);
  }

  void write_log(std::string_view line) {
    if (!log_file) return;
    fmt::print(log_file, "{:%Y-%m-%d %H:%M:%S} {}\n", fmt::localtime(std::time(nullptr)), line);
    std::fflush(log_file);
  }

  // The handler only writes to a pipe, whichever thread it runs on (libraries start some of their own); this thread
  // reads.
  void watch_signals() {
    COLLINEA_CHECK(::pipe2(wake, O_CLOEXEC) == 0);
    signal_pipe = wake[1];
    for (const int number : {SIGINT, SIGTERM}) {
      struct sigaction action {};
      sigaction(number, nullptr, &action);
      if (action.sa_handler == SIG_IGN) continue;  // started in the background or by nohup: it stays so
      action.sa_handler = on_signal;
      action.sa_flags = SA_RESTART;
      sigaction(number, &action, nullptr);
    }
    signals = std::thread([this] {
      if (next_byte(-1) != kSignal) return;
      stop.request_stop();
      say("stopping; what is done is kept");
      if (next_byte(kGrace_ms) == kQuit) return;
      // Asked twice, or in the middle of something long. Files and database are made to be left at any moment.
      say("stopped; the same command goes on from here");
      _exit(exit_code(Errc::kCancelled));
    });
  }

  // What comes through the pipe; 0 when nothing does for so long (negative: wait for ever).
  char next_byte(int timeout_ms) const {
    char byte = 0;
    pollfd waiting{wake[0], POLLIN, 0};
    int ready = 0;
    do ready = ::poll(&waiting, 1, timeout_ms);
    while (ready < 0 && errno == EINTR);
    return ready > 0 && ::read(wake[0], &byte, 1) == 1 ? byte : char{0};
  }

  void unwatch_signals() {
    if (!signals.joinable()) return;
    [[maybe_unused]] const auto written = ::write(wake[1], &kQuit, 1);
    signals.join();
    signal_pipe = -1;
    for (const int end : wake) ::close(end);
  }
};

Console::Console() : state_(std::make_unique<State>()) {}
Console::Console(Console&&) noexcept = default;
Console& Console::operator=(Console&&) noexcept = default;
Console::~Console() {
  if (state_) state_->unwatch_signals();
}

Result<Console> Console::create(const ConsoleOptions& options, SpellOption spelling) {
  COLLINEA_TRY(validate(options));
  Console console;
  State& state = *console.state_;
  state.show = options.progress;
  if (state.show == ProgressForm::kAuto) state.show = isatty(STDERR_FILENO) ? ProgressForm::kBar : ProgressForm::kLines;
  state.spelling = std::move(spelling);
  const int available = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  state.threads = options.threads > 0 ? options.threads : available;
  state.watch_signals();
  return console;
}

void Console::log_to(const std::filesystem::path& file) {
  const std::lock_guard lock(state_->mutex);
  if (state_->log_file) std::fclose(state_->log_file);
  state_->log_file = std::fopen(file.c_str(), "a");
}

Run Console::run() {
  State* state = state_.get();
  return {.stop = state->stop.get_token(),
          .progress = [state](std::string_view stage, double done) { state->progress(stage, done); },
          .log = [state](std::string_view line) { state->say(line); },
          .threads = state->threads,
          .spelling = state->spelling};
}

int Console::complain(const Error& error) {
  State& state = *state_;
  const int code = exit_code(error.code);
  const std::string text = text_of(error, state.spelling);
  const std::lock_guard lock(state.mutex);
  state.clear_bar();
  if (state.show == ProgressForm::kJson)
    fmt::print(stderr, "{{\"error\":\"{}\",\"exit_code\":{}}}\n", json_escaped(text), code);
  else
    fmt::print(stderr, "error: {}\n", text);
  state.write_log("error: " + text);
  return code;
}

int complain(const Error& error, const SpellOption& spelling) {
  fmt::print(stderr, "error: {}\n", text_of(error, spelling));
  return exit_code(error.code);
}

}  // namespace collinea
