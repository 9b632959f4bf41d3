// SPDX-License-Identifier: Apache-2.0
// Reads .npy files, version 1.0, by the letter of their specification.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/temp_folder.hpp"

namespace choreo::test {

struct NpyFile {
  std::string dtype;               ///< As written: "<f4".
  std::vector<std::size_t> shape;  ///< Empty for a scalar.
  Bytes data;

  [[nodiscard]] std::size_t count() const {
    std::size_t product = 1;
    for (const auto n : shape) product *= n;
    return product;
  }

  /// All values, row by row. @throws std::runtime_error where the file has another length than its shape says.
  template <typename T>
  [[nodiscard]] std::vector<T> values() const {
    if (data.size() != count() * sizeof(T)) throw std::runtime_error("the array has another length than its shape");
    std::vector<T> all(count());
    if (!all.empty()) std::memcpy(all.data(), data.data(), data.size());
    return all;
  }
};

/// @throws std::runtime_error where it is missing or not such a file.
inline NpyFile read_npy(const std::string& path) {
  const auto bytes = read_bytes(path);
  const std::string magic("\x93NUMPY\x01\x00", 8);
  if (bytes.size() < 10 || std::memcmp(bytes.data(), magic.data(), 8) != 0)
    throw std::runtime_error(path + ": no .npy");
  const std::size_t length = bytes[8] + 256U * bytes[9];
  if (bytes.size() < 10 + length || (10 + length) % 64 != 0)
    throw std::runtime_error(path + ": header cut or unaligned");
  const std::string header(bytes.begin() + 10, bytes.begin() + static_cast<std::ptrdiff_t>(10 + length));
  const auto behind = [&](const std::string& key) {
    const auto at = header.find("'" + key + "':");
    if (at == std::string::npos) throw std::runtime_error(path + ": no " + key);
    return header.substr(header.find_first_not_of(' ', at + key.size() + 3));
  };
  if (!behind("fortran_order").starts_with("False")) throw std::runtime_error(path + ": not row by row");
  NpyFile file;
  const auto descr = behind("descr");
  file.dtype = descr.substr(1, descr.find('\'', 1) - 1);
  const auto tuple = behind("shape");
  for (std::size_t i = 1; i < tuple.size() && tuple[i] != ')';) {
    if (tuple[i] < '0' || tuple[i] > '9') {
      ++i;
      continue;
    }
    std::size_t digits = 0;
    file.shape.push_back(std::stoul(tuple.substr(i), &digits));
    i += digits;
  }
  file.data.assign(bytes.begin() + static_cast<std::ptrdiff_t>(10 + length), bytes.end());
  return file;
}

}  // namespace choreo::test
