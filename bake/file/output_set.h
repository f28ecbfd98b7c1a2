// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bake/file/checked_file.h"

namespace photic {

/// The files of one run: what it reads, and what it will write.
///
/// A verb names all of them before it works. A file that would be written twice, or that is read too, is refused then,
/// whatever names and links lead to it; so is what cannot be written. Files are made under temporary names and renamed
/// together:
/// - until every byte of every file of a group is on the disk, no target changes;
/// - when a rename fails, those before it are undone: all files are the old ones (where the file system has hard
///   links);
/// - a run that is killed between the first and the last rename of a group, a matter of microseconds, leaves some new
///   and some old: POSIX renames one file at a time. Each file is whole, and the last to be opened, which others should
///   look for first, is the last to appear.
class OutputSet {
public:
    /// A file that the run reads. One that does not exist is left to whoever reads it.
    /// @param role  for messages: "the scene"
    /// @throws Error{Usage} when the run writes it
    void reads(const std::string& role, const std::string& path);
    void reads(const std::string& role, const std::vector<std::string>& paths);

    /// A file that the run will write. Its folder is made where there is none.
    /// @throws Error{Usage} when the run reads it, or writes it as something else too; Error{Failed} when it cannot be
    /// written (writeTarget() in pending_file.h)
    void writes(const std::string& role, const std::string& path);

    /// A file whose name the user has not given, since it follows from another's: then only a file of its kind may be
    /// replaced.
    /// @param is_own_kind  of an existing file, by its path
    /// @throws as writes(); Error{Usage} for a file of another kind
    void writesBeside(const std::string& role, const std::string& path,
                      const std::function<bool(const std::string&)>& is_own_kind);

    /// Opens a file of the next group; claims it where writes() has not. It belongs to this set. Whoever writes it
    /// calls finish().
    CheckedFile& open(const std::string& path);
    /// A whole file of the next group.
    void write(const std::string& path, std::string_view bytes);

    /// Bytes of a file of the next group so far.
    std::int64_t pendingBytes(const std::string& path) const;

    /// Puts the group on the disk and renames it, in the order of opening. The next file begins another group; what was
    /// claimed stays claimed. @throws Error{Failed}: then all files are the old ones
    void commit();
    /// Gives the group up: its targets stay as they were. A run that goes on after a failure calls it first.
    void discard() { group_.clear(); }

private:
    /// A name in a folder, whatever path leads to it.
    struct Place {
        std::uint64_t device = 0, folder = 0;
        std::string name;
        auto operator<=>(const Place&) const = default;
    };
    /// A file, whatever name it has.
    struct Inode {
        std::uint64_t device = 0, number = 0;
        auto operator<=>(const Inode&) const = default;
    };
    struct Named {
        std::string role, path;
    };
    static void makeFolderOf(const std::string& path);
    static Place placeOf(const std::string& path);
    static bool inodeOf(const std::string& path, Inode& inode);
    [[noreturn]] static void refuseSame(const Named& one, const Named& other);

    std::map<Place, Named> written_;
    std::map<Inode, Named> written_over_, read_;
    std::vector<std::unique_ptr<CheckedFile>> group_;
};

}  // namespace photic
