// SPDX-License-Identifier: Apache-2.0
// Says where a source tree breaks the rules of its layers: include_layers ROOT; exit status 1 where it does.
#include <iostream>

#include "architecture/layers.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: include_layers ROOT\n";
    return 2;
  }
  const auto survey = choreo::architecture::survey(argv[1]);
  for (const auto& v : survey.violations) std::cout << v.file << ":" << v.line << ": " << v.rule << "\n";
  std::cout << survey.files << " files, " << survey.includes << " includes, " << survey.violations.size()
            << " violations\n";
  // A survey of nothing proves nothing.
  return survey.violations.empty() && survey.files > 100 && survey.includes > 100 ? 0 : 1;
}
