// SPDX-License-Identifier: Apache-2.0
// The files of one run: all under their final names, or none.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace choreo::outputs {

/// Writes under temporary names beside the final ones and renames at the end.
///
/// What a destroyed set did not commit is removed, with the folders it made; older files of those names stay.
class OutputSet {
 public:
  /// Makes the folder where it is missing and tries whether it can be written to.
  /// @throws Error (usage) where not.
  explicit OutputSet(std::filesystem::path folder);
  ~OutputSet();
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;

  /// Refuses now what `add` would refuse after the work is done.
  /// @throws Error (usage) where a folder has that name already.
  void check(const std::string& name) const;

  /// Refuses now what the disk could not hold after the work is done.
  /// @param bytes  that will be written at least.  @param what  what needs them, for the message.
  /// @throws Error (usage) where the folder's file system has fewer left.
  void require_space(std::uintmax_t bytes, std::string_view what) const;

  /// Where to write the file that will be `folder / name`.
  /// @throws Error (usage) where a folder has that name already.
  [[nodiscard]] std::filesystem::path add(const std::string& name);

  /// Has `commit` remove the file `folder / name` of an earlier run, if there is one.
  void supersede(const std::string& name);

  /// Gives every file that was added its final name.
  /// @throws Error (failure)
  void commit();

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  struct File {
    std::filesystem::path temporary;
    std::filesystem::path final;
  };
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_folders_;  // Innermost last.
  std::vector<File> files_;
  std::vector<std::filesystem::path> superseded_;
};

/// The final name of a path that `OutputSet::add` gave; any other path as it is. For messages: nobody knows or finds
/// the temporary one.
[[nodiscard]] std::string final_name(const std::filesystem::path& path);

/// Writes a whole file. @throws Error (failure) where the disk is full or the like; the file may then be incomplete.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace choreo::outputs
