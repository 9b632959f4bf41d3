// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/helper_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::devices::openni2 {
namespace {

constexpr std::size_t kMemoryBytes = kSlots * kSlotBytes;
constexpr Nanoseconds kFarewell = std::chrono::milliseconds(1500);
constexpr int kAboveTheHelpers = 10;  // Descriptors that cannot be in the way of those that the helper is given.

[[noreturn]] void cannot_start(std::string_view doing, int cause) {
  throw failure(
      fmt::format("OpenNI2's helper cannot be started: {}: {}", doing, std::generic_category().message(cause)));
}

bool is_program(const std::filesystem::path& path) { return ::access(path.c_str(), X_OK) == 0; }

// What the helper is given, done between fork and exec.
class Actions {
 public:
  Actions() {
    if (::posix_spawn_file_actions_init(&files_) != 0 || ::posix_spawnattr_init(&how_) != 0) {
      cannot_start("no memory", ENOMEM);
    }
    // Out of the terminal's group: an interrupt is ours to answer. And no signal blocked or ignored.
    sigset_t none;
    sigset_t all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    ::posix_spawnattr_setsigmask(&how_, &none);
    ::posix_spawnattr_setsigdefault(&how_, &all);
    ::posix_spawnattr_setpgroup(&how_, 0);
    ::posix_spawnattr_setflags(&how_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    // The library talks; what it says is nothing for the user.
    ::posix_spawn_file_actions_addopen(&files_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    ::posix_spawn_file_actions_addopen(&files_, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  }
  ~Actions() {
    ::posix_spawn_file_actions_destroy(&files_);
    ::posix_spawnattr_destroy(&how_);
  }
  Actions(const Actions&) = delete;
  Actions& operator=(const Actions&) = delete;
  void give(int ours, int theirs) { ::posix_spawn_file_actions_adddup2(&files_, ours, theirs); }
  pid_t spawn(const std::string& program) {
    std::string name = program;
    std::array<char*, 2> arguments{name.data(), nullptr};
    pid_t process = -1;
    const int cause = ::posix_spawn(&process, program.c_str(), &files_, &how_, arguments.data(), environ);
    if (cause != 0) cannot_start(fmt::format("\"{}\"", program), cause);
    return process;
  }

 private:
  posix_spawn_file_actions_t files_{};
  posix_spawnattr_t how_{};
};

Descriptor moved_up(int number, std::string_view doing) {
  if (number < 0) cannot_start(doing, errno);
  const int moved = ::fcntl(number, F_DUPFD_CLOEXEC, kAboveTheHelpers);
  const int cause = errno;
  ::close(number);
  if (moved < 0) cannot_start(doing, cause);
  return Descriptor(moved);
}

// Of a size that nobody can change: a helper gone mad could otherwise make our reading fault.
Descriptor shared_memory() {
  auto file = moved_up(::memfd_create("choreoscope-openni2", MFD_CLOEXEC | MFD_ALLOW_SEALING), "no shared memory");
  if (::ftruncate(file.number(), static_cast<off_t>(kMemoryBytes)) != 0 ||
      ::fcntl(file.number(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    cannot_start("no shared memory", errno);
  }
  return file;
}

}  // namespace

void Descriptor::reset() {
  if (number_ >= 0) ::close(number_);
  number_ = -1;
}

std::string helper_program() {
  namespace fs = std::filesystem;
  constexpr auto kName = "choreoscope-openni2";
  if (const char* given = std::getenv("CHOREO_OPENNI2_HELPER"); given != nullptr && *given != '\0') {
    if (is_program(given)) return given;
    throw usage_error(fmt::format("\"{}\" is no program that can be run", given), "CHOREO_OPENNI2_HELPER",
                      fmt::format("it names the program {}", kName));
  }
  std::error_code problem;
  const auto here = fs::read_symlink("/proc/self/exe", problem).parent_path();
  for (const auto& path : {here / kName, here / CHOREO_LIBEXEC_FROM_BIN / kName}) {
    if (is_program(path)) return path.string();
  }
  throw usage_error(fmt::format("OpenNI2 needs the program {}, which is not there", kName), {},
                    fmt::format("it is installed with choreoscope, and looked for in {} and {}", here.string(),
                                (here / CHOREO_LIBEXEC_FROM_BIN).lexically_normal().string()));
}

HelperProcess::HelperProcess(const Request& request, const Descriptor& recording)
    : gentle_(request.action == Action::kDevice), memory_file_(shared_memory()) {
  const auto program = helper_program();
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) cannot_start("no socket", errno);
  socket_ = Descriptor(ends[0]);
  const auto theirs = moved_up(ends[1], "no socket");
  auto* memory = ::mmap(nullptr, kMemoryBytes, PROT_READ, MAP_SHARED, memory_file_.number(), 0);
  if (memory == MAP_FAILED) cannot_start("no shared memory", errno);
  memory_ = static_cast<std::uint8_t*>(memory);
  try {
    start(program, theirs, recording);
  } catch (...) {
    ::munmap(memory_, kMemoryBytes);
    throw;
  }
  send(request);
}

void HelperProcess::start(const std::string& program, const Descriptor& far_end, const Descriptor& recording) {
  Actions actions;
  actions.give(far_end.number(), kSocketDescriptor);
  actions.give(memory_file_.number(), kMemoryDescriptor);
  std::optional<Descriptor> moved;
  if (recording.number() >= 0) {
    moved.emplace(::fcntl(recording.number(), F_DUPFD_CLOEXEC, kAboveTheHelpers));
    if (moved->number() < 0) cannot_start("no descriptor", errno);
    actions.give(moved->number(), kRecordingDescriptor);
  }
  process_ = actions.spawn(program);
}

HelperProcess::~HelperProcess() {
  socket_.reset();
  if (process_ > 0) {
    const bool ended = gentle_ && reap(kFarewell);
    if (!ended && process_ > 0) {
      ::kill(process_, SIGKILL);
      (void)reap(kFarewell);  // One that is stuck in the kernel is left to init.
    }
  }
  ::munmap(memory_, kMemoryBytes);
}

// How it ended; nothing where it did not within `patience`.
std::optional<int> HelperProcess::reap(Nanoseconds patience) {
  if (process_ <= 0) return 0;
  constexpr auto kStep = std::chrono::milliseconds(2);
  for (Nanoseconds waited{0};; waited += kStep) {
    int status = 0;
    const auto got = ::waitpid(process_, &status, WNOHANG);
    if (got == process_ || (got < 0 && errno != EINTR)) {
      process_ = -1;
      return got > 0 ? status : 0;
    }
    if (waited >= patience) return std::nullopt;
    std::this_thread::sleep_for(kStep);
  }
}

void HelperProcess::send(const Message& message) {
  const auto bytes = encode(message);
  // Where it is gone, `next` says why.
  (void)::send(socket_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

std::string HelperProcess::told_of_end() {
  const auto status = reap(kFarewell);
  if (!status) return "OpenNI2's helper hangs";
  if (WIFSIGNALED(*status)) {
    return fmt::format("OpenNI2 crashed ({})", ::strsignal(WTERMSIG(*status)));
  }
  if (WEXITSTATUS(*status) == 127) return "OpenNI2's helper cannot start: is the package libopenni2-0 installed?";
  return fmt::format("OpenNI2's helper ended with status {}", WEXITSTATUS(*status));
}

std::optional<Message> HelperProcess::next(Nanoseconds patience) {
  pollfd ready{socket_.number(), POLLIN, 0};
  const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(std::max(patience, Nanoseconds{0})).count();
  const int polled = ::poll(&ready, 1, static_cast<int>(std::min<std::int64_t>(milliseconds, 60000)));
  if (polled == 0 || (polled < 0 && errno == EINTR)) return std::nullopt;
  std::array<std::uint8_t, kMostMessage> bytes{};
  const auto got = ::recv(socket_.number(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_TRUNC);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (got <= 0) throw HelperGone(told_of_end());
  if (static_cast<std::size_t>(got) > bytes.size())
    throw HelperGone("OpenNI2's helper went mad: a message is too long");
  try {
    return decode({bytes.data(), static_cast<std::size_t>(got)});
  } catch (const BadMessage& bad) {
    throw HelperGone(fmt::format("OpenNI2's helper went mad: {}", bad.what()));
  }
}

std::span<const std::uint8_t> HelperProcess::pixels(const Picture& picture) const {
  return {memory_ + picture.slot * kSlotBytes, picture.bytes};
}

void HelperProcess::release(const Picture& picture) { send(Release{picture.slot}); }

}  // namespace choreo::devices::openni2
