// SPDX-License-Identifier: Apache-2.0
// Parallel loops with one worker, for the thread sanitizer: it sees nothing of how TBB and OpenCV hand work over and
// would take every such loop for a race.
#include <tbb/global_control.h>
#include <opencv2/core/utility.hpp>

namespace {

const tbb::global_control kOneWorker(tbb::global_control::max_allowed_parallelism, 1);
const bool kOneOfOpenCv = (cv::setNumThreads(1), true);

}  // namespace
