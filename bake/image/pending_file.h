// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace photic {

/// Where a file that is to be written really goes.
struct WriteTarget {
    std::string path;      ///< symbolic links followed to their end, which need not exist
    bool exists = false;   ///< a regular file is there, and is replaced
    unsigned mode = 0666;  ///< permissions of the file that is replaced
};

/// Follows symbolic links from `path`, and refuses what cannot be written: a folder, a device or a pipe (renaming a
/// file onto one would replace it), a missing or closed folder, a write-protected file, links that lead in a circle.
/// @throws Error{Failed} with what would do instead
WriteTarget writeTarget(const std::string& path);

/// Removes what killed runs left in the folder of `target` while they wrote `target`, under today's names and former
/// ones.
///
/// A file that is being written is locked (flock), and a lock ends with its process: so the dead are told from the
/// living in containers too, where process numbers come again. A file of another machine, or of a time before this
/// machine started, must also be a day old: some network file systems keep locks to one machine.
/// @return the files that are gone
std::vector<std::string> removeLeftovers(const std::string& target);

/// A file under a temporary name beside its target, which no other process can have chosen. Unless commit() succeeds,
/// the target is untouched and the temporary file goes with this object. Leftovers of dead processes for the same
/// target are removed first. The file has the permissions of the one that it replaces.
class PendingFile {
public:
    /// @throws Error{Failed} where writeTarget() does, or when the file cannot be created
    explicit PendingFile(const std::string& path);
    ~PendingFile();
    PendingFile(const PendingFile&) = delete;
    PendingFile& operator=(const PendingFile&) = delete;

    const std::string& path() const { return path_; }  ///< as it was given
    const WriteTarget& target() const { return target_; }
    const std::string& temporaryPath() const { return temporary_; }
    int descriptor() const { return descriptor_; }

    /// Puts every byte on the disk. @return 0, or the system's reason
    int flush();
    /// Keeps the file that will be replaced, under a temporary name, so that undo() can bring it back. A file system
    /// that cannot (no hard links) keeps nothing.
    void keepOld();
    /// Renames to the target. @return 0, or the system's reason
    int commit();
    /// After commit(): the old file is there again, or none where there was none.
    void undo();

private:
    std::string path_, temporary_, kept_;
    WriteTarget target_;
    int descriptor_ = -1, kept_descriptor_ = -1;
    bool committed_ = false;
};

/// Makes renames in the folder of `path` survive a power cut, as far as its file system can.
void flushFolderOf(const std::string& path);

}  // namespace photic
