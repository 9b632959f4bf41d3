// SPDX-License-Identifier: Apache-2.0
#include "support/program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace choreo::test {
namespace {

using SteadyClock = std::chrono::steady_clock;

struct Pipe {
  Pipe() {
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  }
  ~Pipe() {
    for (const int end : ends) {
      if (end >= 0) ::close(end);
    }
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close(std::size_t end) {
    ::close(ends[end]);
    ends[end] = -1;
  }
  // Until there is no room for a byte. @return how many there are in it.
  [[nodiscard]] std::size_t fill() const {
    const int flags = ::fcntl(ends[1], F_GETFL);
    if (::fcntl(ends[1], F_SETFL, flags | O_NONBLOCK) != 0) throw std::runtime_error("no pipe that is full");
    std::size_t bytes = 0;
    for (std::size_t portion = 4096; portion > 0;) {
      const std::string some(portion, '.');
      const auto count = ::write(ends[1], some.data(), some.size());
      count > 0 ? void(bytes += static_cast<std::size_t>(count)) : void(portion /= 2);
    }
    if (::fcntl(ends[1], F_SETFL, flags) != 0) throw std::runtime_error("no pipe that is full");
    return bytes;
  }
  std::array<int, 2> ends{-1, -1};
};

std::vector<std::string> environment_with(const std::vector<std::pair<std::string, std::string>>& added) {
  std::vector<std::string> all;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text(*entry);
    bool replaced = false;
    for (const auto& [name, value] : added) replaced = replaced || text.starts_with(name + "=");
    if (!replaced) all.push_back(text);
  }
  for (const auto& [name, value] : added) all.push_back(name + "=" + value);
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (auto& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

// What the child does between fork and exec: system calls only.
[[noreturn]] void become(const char* path, char* const* arguments, char* const* environment, const RunOptions& options,
                         int out, int err) {
  if (::dup2(out, STDOUT_FILENO) < 0 || ::dup2(err, STDERR_FILENO) < 0) ::_exit(127);
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing < 0 || ::dup2(nothing, STDIN_FILENO) < 0) ::_exit(127);
  if (options.file_size_limit) {
    const rlimit limit{*options.file_size_limit, *options.file_size_limit};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(127);
  }
  // What a test ignores its child would ignore, too.
  std::signal(SIGPIPE, SIG_DFL);
  if (!options.folder.empty() && ::chdir(options.folder.c_str()) != 0) ::_exit(127);
  ::execve(path, arguments, environment);
  ::_exit(127);
}

}  // namespace

std::vector<std::string> Outcome::err_lines() const {
  std::vector<std::string> lines;
  std::istringstream in(err);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> Outcome::err_lines(const std::string& start) const {
  std::vector<std::string> lines;
  for (const auto& line : err_lines()) {
    if (line.starts_with(start)) lines.push_back(line.substr(start.size()));
  }
  return lines;
}

std::string Outcome::told() const {
  std::ostringstream text;
  text << "status " << status << ", signal " << signal << (timed_out ? ", timed out" : "") << "\nstdout:\n"
       << out << "stderr:\n"
       << err;
  return text.str();
}

Outcome run_program(const std::string& path, const std::vector<std::string>& arguments, const RunOptions& options) {
  std::vector<std::string> words{path};
  words.insert(words.end(), arguments.begin(), arguments.end());
  auto variables = environment_with(options.environment);
  const auto argv = pointers(words);
  const auto envp = pointers(variables);
  std::array<Pipe, 2> pipes;
  const auto filling = options.full_err ? pipes[1].fill() : 0;
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) become(path.c_str(), argv.data(), envp.data(), options, pipes[0].ends[1], pipes[1].ends[1]);
  for (auto& pipe : pipes) pipe.close(1);
  if (options.started) options.started(child);

  Outcome run;
  std::array<std::string*, 2> texts{&run.out, &run.err};
  std::size_t heard = 0;  // How much of stderr the pokes have used up.
  const auto deadline = SteadyClock::now() + options.limit;
  while (pipes[0].ends[0] >= 0 || pipes[1].ends[0] >= 0) {
    std::array<pollfd, 2> waiting{pollfd{pipes[0].ends[0], POLLIN, 0}, pollfd{pipes[1].ends[0], POLLIN, 0}};
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - SteadyClock::now()).count();
    const int ready = left > 0 ? ::poll(waiting.data(), waiting.size(), static_cast<int>(left)) : 0;
    if (ready == 0 && !run.timed_out) {
      run.timed_out = true;
      ::kill(child, SIGKILL);
      break;
    }
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      if (waiting[i].fd < 0 || waiting[i].revents == 0) continue;
      std::array<char, 4096> buffer{};
      const auto count = ::read(waiting[i].fd, buffer.data(), buffer.size());
      if (count > 0) texts[i]->append(buffer.data(), static_cast<std::size_t>(count));
      if (count == 0 || (count < 0 && errno != EINTR)) pipes[i].close(0);
    }
    while (run.poked < options.pokes.size()) {
      const auto& poke = options.pokes[run.poked];
      const auto place = run.err.find(poke.after, heard);
      if (place == std::string::npos) break;
      heard = place + poke.after.size();
      ::kill(child, poke.signal);
      ++run.poked;
    }
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) run.status = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) run.signal = WTERMSIG(status);
  run.err.erase(0, filling);
  return run;
}

bool ends_within(int process, std::chrono::seconds limit) {
  const auto deadline = SteadyClock::now() + limit;
  do {
    siginfo_t how{};
    if (::waitid(P_PID, static_cast<id_t>(process), &how, WEXITED | WNOHANG | WNOWAIT) == 0 && how.si_pid == process) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  } while (SteadyClock::now() < deadline);
  return false;
}

}  // namespace choreo::test
