// SPDX-License-Identifier: Apache-2.0
#include "bake/file/output_set.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "bake/report/error.h"

namespace photic {

OutputSet::Place OutputSet::placeOf(const std::string& path) {
    const std::filesystem::path target(path);
    const std::string folder = target.has_parent_path() ? target.parent_path().string() : ".";
    struct stat status {};
    ::stat(folder.c_str(), &status);
    return {static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino),
            target.filename().string()};
}

bool OutputSet::inodeOf(const std::string& path, Inode& inode) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return false;
    inode = {static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino)};
    return true;
}

void OutputSet::refuseSame(const Named& one, const Named& other) {
    const std::string names =
        one.path == other.path ? std::string() : fmt::format(" ('{}' and '{}')", one.path, other.path);
    throw Error(ErrorCode::Usage,
                fmt::format("{} and {} are one file{}; give the output a name of its own", one.role, other.role, names),
                other.path);
}

void OutputSet::makeFolderOf(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code failure;
    if (folder.empty() || std::filesystem::exists(folder, failure)) return;
    std::filesystem::create_directories(folder, failure);
    if (failure)
        throw Error(ErrorCode::Failed,
                    fmt::format("cannot write there: the directory '{}' cannot be made ({}); choose another",
                                folder.string(), failure.message()),
                    path);
}

void OutputSet::reads(const std::string& role, const std::string& path) {
    Inode inode;
    if (!inodeOf(path, inode)) return;
    read_.emplace(inode, Named{role, path});
    if (const auto written = written_over_.find(inode); written != written_over_.end())
        refuseSame({role, path}, written->second);
}

void OutputSet::reads(const std::string& role, const std::vector<std::string>& paths) {
    for (const std::string& path : paths) reads(role, path);
}

void OutputSet::writes(const std::string& role, const std::string& path) {
    makeFolderOf(path);
    const WriteTarget target = writeTarget(path);
    const auto [before, fresh] = written_.emplace(placeOf(target.path), Named{role, path});
    if (!fresh) refuseSame(before->second, {role, path});
    Inode inode;
    if (!inodeOf(target.path, inode)) return;
    if (const auto input = read_.find(inode); input != read_.end()) refuseSame(input->second, {role, path});
    written_over_.emplace(inode, Named{role, path});
}

void OutputSet::writesBeside(const std::string& role, const std::string& path,
                             const std::function<bool(const std::string&)>& is_own_kind) {
    writes(role, path);
    const WriteTarget target = writeTarget(path);
    if (!target.exists || is_own_kind(target.path)) return;
    throw Error(ErrorCode::Usage,
                fmt::format("{} would replace a file that is none; move that away, or choose another -o", role), path);
}

CheckedFile& OutputSet::open(const std::string& path) {
    if (written_.find(placeOf(writeTarget(path).path)) == written_.end()) writes("an output", path);
    group_.push_back(std::make_unique<CheckedFile>(path));
    return *group_.back();
}

void OutputSet::write(const std::string& path, std::string_view bytes) {
    CheckedFile& file = open(path);
    try {
        file.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    } catch (const std::ios_base::failure&) {
        file.fail(file.buffer().failure());
    }
    file.finish();
}

std::int64_t OutputSet::pendingBytes(const std::string& path) const {
    const auto file = std::find_if(group_.begin(), group_.end(), [&](const auto& f) { return f->path() == path; });
    return file == group_.end() ? 0 : (*file)->size();
}

void OutputSet::commit() {
    for (const auto& file : group_)
        if (!file->finished()) throw std::logic_error("a file of the set was not finished: " + file->path());
    if (group_.size() > 1)
        for (const auto& file : group_) file->pending().keepOld();
    for (std::size_t i = 0; i < group_.size(); ++i) {
        const int reason = group_[i]->pending().commit();
        if (reason == 0) continue;
        for (std::size_t done = i; done-- > 0;) group_[done]->pending().undo();
        group_[i]->fail(reason);
    }
    std::set<std::string> folders;
    for (const auto& file : group_) {
        const std::string& target = file->pending().target().path;
        if (folders.insert(std::filesystem::path(target).parent_path().string()).second) flushFolderOf(target);
    }
    // The files that were replaced are no more; their numbers may come again.
    std::erase_if(written_over_, [this](const auto& old) {
        return std::any_of(group_.begin(), group_.end(),
                           [&](const auto& file) { return file->path() == old.second.path; });
    });
    group_.clear();
}

}  // namespace photic
