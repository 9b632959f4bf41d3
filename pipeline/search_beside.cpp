// SPDX-License-Identifier: Apache-2.0
#include "pipeline/search_beside.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <utility>

namespace choreo::pipeline {
namespace {

constexpr int kNice = 10;  // Of the thread that searches.

}  // namespace

// What is not const belongs to `mutex_`.
struct SearchBeside::Job {
  const std::function<void()> search;
  const std::int64_t due;
  bool done = false, is_void = false;
  std::exception_ptr problem = nullptr;
};

SearchBeside::SearchBeside(std::string thread, bool waits, WhenLate when_late)
    : waits_(waits), when_late_(when_late), thread_([this, name = std::move(thread)] { work(name); }) {}

SearchBeside::~SearchBeside() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void SearchBeside::work(const std::string& name) {
  pthread_setname_np(pthread_self(), name.c_str());
  // Frames come first; where that cannot be had, it is as it was.
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  for (;;) {
    std::shared_ptr<Job> job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stopping_ || !waiting_.empty(); });
      if (stopping_) return;
      job = std::move(waiting_.front());
      waiting_.pop_front();
    }
    std::exception_ptr problem;
    try {
      job->search();
    } catch (...) {
      problem = std::current_exception();
    }
    {
      const std::scoped_lock lock(mutex_);
      job->problem = problem;
      job->done = true;
      if (job->is_void && problem) problem_ = problem;
    }
    changed_.notify_all();
  }
}

SearchBeside::Due SearchBeside::begin_frame(std::int64_t now, bool was_late) {
  std::shared_ptr<Job> job;  // Before the lock: what it holds is freed without.
  std::unique_lock lock(mutex_);
  if (problem_) std::rethrow_exception(problem_);
  if (pending_.empty() || pending_.front()->due > now) return Due::kNothing;
  job = pending_.front();
  if (waits_ && !was_late) changed_.wait(lock, [&] { return job->done; });
  if (!job->done || was_late) {
    ++late_;
    if (when_late_ == WhenLate::kVoid) {
      pending_.pop_front();
      job->is_void = true;
      std::erase(waiting_, job);  // Where it was not begun: what it holds is memory.
    }
    return Due::kLate;
  }
  pending_.pop_front();
  if (job->problem) std::rethrow_exception(job->problem);
  return Due::kDone;
}

void SearchBeside::ask(std::function<void()> search, std::int64_t due) {
  auto job = std::make_shared<Job>(Job{std::move(search), due});
  ++asked_;
  pending_.push_back(job);
  {
    const std::scoped_lock lock(mutex_);
    waiting_.push_back(std::move(job));
  }
  changed_.notify_all();
}

}  // namespace choreo::pipeline
