// SPDX-License-Identifier: Apache-2.0
#include "recognition/semaphore_speller.hpp"

#include <algorithm>
#include <vector>

namespace choreo::recognition {
namespace {

double median(const std::deque<double>& values) {
  std::vector<double> sorted(values.begin(), values.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

}  // namespace

SemaphoreSpeller::SemaphoreSpeller(const SemaphoreOptions& options) : state_{options.word_gap, {}} {
  options.validate();
}

void SemaphoreSpeller::write(char c) {
  if (state_.space && !text_.empty()) text_ += ' ';
  state_.space = false;
  text_ += c;
}

void SemaphoreSpeller::add(const HeldSign& held) {
  constexpr std::size_t kLetters = 9;
  const auto sign = held.sign;
  const double seconds = held.to - held.from;
  if (sign == "REST") {
    if (!state_.letter_seconds.empty() && seconds >= state_.word_gap * median(state_.letter_seconds))
      state_.space = true;
    return;
  }
  if (sign == kAttention) return;
  if (sign == kError) {
    const auto gap = text_.rfind(' ');
    state_.space = gap != std::string::npos;
    text_.resize(state_.space ? gap : 0);
    return;
  }
  state_.letter_seconds.push_back(seconds);
  if (state_.letter_seconds.size() > kLetters) state_.letter_seconds.pop_front();
  if (sign == "NUMERALS") {
    state_.numerals = true;
  } else if (sign == "CANCEL") {
    state_.space = false;
    if (!text_.empty()) text_.pop_back();
    // A word of one letter leaves the space before it to the next.
    if (!text_.empty() && text_.back() == ' ') {
      text_.pop_back();
      state_.space = true;
    }
  } else if (!state_.numerals) {
    write(sign.front());
  } else if (sign == "J") {
    state_.numerals = false;
  } else if (sign == "K") {
    write('0');
  } else if (sign <= "I") {
    write(static_cast<char>('1' + (sign.front() - 'A')));
  } else {
    write(sign.front());
  }
}

void SemaphoreSpeller::keep_end(std::size_t most) {
  if (text_.size() <= most) return;
  auto old = text_.size() - most;
  if (most > 0 && text_[old] == ' ') ++old;
  text_.erase(0, old);
}

std::string SemaphoreSpeller::text_with(const std::optional<HeldSign>& held, std::size_t most) const {
  const auto end_of = [](const std::string& text, std::size_t size) {
    return text.substr(text.size() - std::min(text.size(), size));
  };
  if (!held) return end_of(text_, most);
  // What the sign takes away is not what is wanted: a word, or a letter with the space before it.
  std::size_t taken = 2;
  if (held->sign == kError) {
    const auto gap = text_.rfind(' ');
    taken = text_.size() - (gap == std::string::npos ? 0 : gap);
  }
  SemaphoreSpeller other;
  other.state_ = state_;
  other.text_ = end_of(text_, most > text_.size() ? text_.size() : most + taken);
  other.add(*held);
  return end_of(other.text_, most);
}

}  // namespace choreo::recognition
