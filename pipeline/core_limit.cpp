// SPDX-License-Identifier: Apache-2.0
#include "pipeline/core_limit.hpp"

#include <cassert>
#include <cstddef>

#include <tbb/global_control.h>
#include <opencv2/core/utility.hpp>

namespace choreo::pipeline {

struct CoreLimit::Limits {
  tbb::global_control loops;
  int opencv_before;
};

CoreLimit::CoreLimit(int threads)
    : limits_(new Limits{{tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)},
                         cv::getNumThreads()}) {
  assert(threads >= 1);
  cv::setNumThreads(1);
}

CoreLimit::~CoreLimit() { cv::setNumThreads(limits_->opencv_before); }

}  // namespace choreo::pipeline
