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

SemaphoreSpeller::SemaphoreSpeller(const SemaphoreOptions& options) : word_gap_(options.word_gap) {
  options.validate();
}

void SemaphoreSpeller::write(char c) {
  if (space_ && !text_.empty()) text_ += ' ';
  space_ = false;
  text_ += c;
}

void SemaphoreSpeller::add(const HeldSign& held) {
  constexpr std::size_t kLetters = 9;
  const auto sign = held.sign;
  const double seconds = held.to - held.from;
  if (sign == "REST") {
    if (!letter_seconds_.empty() && seconds >= word_gap_ * median(letter_seconds_)) space_ = true;
    return;
  }
  if (sign == kAttention) return;
  if (sign == kError) {
    const auto gap = text_.rfind(' ');
    space_ = gap != std::string::npos;
    text_.resize(space_ ? gap : 0);
    return;
  }
  letter_seconds_.push_back(seconds);
  if (letter_seconds_.size() > kLetters) letter_seconds_.pop_front();
  if (sign == "NUMERALS") {
    numerals_ = true;
  } else if (sign == "CANCEL") {
    space_ = false;
    if (!text_.empty()) text_.pop_back();
    // A word of one letter leaves the space before it to the next.
    if (!text_.empty() && text_.back() == ' ') {
      text_.pop_back();
      space_ = true;
    }
  } else if (!numerals_) {
    write(sign.front());
  } else if (sign == "J") {
    numerals_ = false;
  } else if (sign == "K") {
    write('0');
  } else if (sign <= "I") {
    write(static_cast<char>('1' + (sign.front() - 'A')));
  } else {
    write(sign.front());
  }
}

std::string SemaphoreSpeller::text_with(const std::optional<HeldSign>& held) const {
  if (!held) return text_;
  auto other = *this;
  other.add(*held);
  return other.text_;
}

}  // namespace choreo::recognition
