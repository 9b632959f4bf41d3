// SPDX-License-Identifier: Apache-2.0
// Reads .npy files, version 1.0, by the letter of their specification.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
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

  /// All values, row by row.
  template <typename T>
  [[nodiscard]] std::vector<T> values() const {
    if (data.size() != count() * sizeof(T)) throw std::runtime_error("values of another size than " + dtype);
    std::vector<T> all(count());
    if (!all.empty()) std::memcpy(all.data(), data.data(), data.size());
    return all;
  }
};

/// Reads all of it, or of the first dimension only `count` items from item `first` on: of large files.
/// @throws std::runtime_error where it is missing or not such a file.
inline NpyFile read_npy(const std::string& path, std::size_t first = 0, std::size_t count = SIZE_MAX) {
  std::ifstream in(path, std::ios::binary);
  std::string prefix(10, '\0');
  in.read(prefix.data(), 10);
  if (!in || !prefix.starts_with(std::string("\x93NUMPY\x01\x00", 8))) throw std::runtime_error(path + ": no .npy");
  const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(prefix[i])); };
  std::string header(byte(8) + 256 * byte(9), '\0');
  in.read(header.data(), static_cast<std::streamsize>(header.size()));
  if (!in || (10 + header.size()) % 64 != 0) throw std::runtime_error(path + ": header cut or unaligned");
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
  in.seekg(0, std::ios::end);
  const auto begin = 10 + header.size();
  const auto bytes = static_cast<std::size_t>(in.tellg()) - begin;
  // The last character of the type is its size: <f4, <f8, |u1.
  if (bytes != file.count() * static_cast<std::size_t>(file.dtype.back() - '0')) {
    throw std::runtime_error(path + ": the file has another length than its shape says");
  }
  const auto items = file.shape.empty() ? 1 : file.shape[0];
  if (first > items) throw std::runtime_error(path + ": has fewer items");
  const auto taken = std::min(count, items - first);
  const auto item_bytes = items == 0 ? 0 : bytes / items;
  if (!file.shape.empty()) file.shape[0] = taken;
  file.data.resize(taken * item_bytes);
  in.seekg(static_cast<std::streamoff>(begin + first * item_bytes));
  in.read(reinterpret_cast<char*>(file.data.data()), static_cast<std::streamsize>(file.data.size()));
  if (!in) throw std::runtime_error(path + ": cannot be read");
  return file;
}

}  // namespace choreo::test
