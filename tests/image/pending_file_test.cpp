// SPDX-License-Identifier: Apache-2.0
#include "bake/image/pending_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "bake/image/atomic_file.h"
#include "bake/report/error.h"

namespace photic {
namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

class PendingFileTest : public testing::Test {
protected:
    void SetUp() override {
        std::string name = (fs::temp_directory_path() / "photic_pending_XXXXXX").string();
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string at(const std::string& name) const { return (folder_ / name).string(); }
    void write(const std::string& name, const std::string& bytes) const { std::ofstream(at(name)) << bytes; }
    std::string read(const std::string& name) const {
        std::ifstream in(at(name));
        return {std::istreambuf_iterator<char>(in), {}};
    }
    Strings names() const {
        Strings names;
        for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename().string());
        std::sort(names.begin(), names.end());
        return names;
    }
    static unsigned modeOf(const std::string& path) {
        struct stat status {};
        return ::stat(path.c_str(), &status) == 0 ? status.st_mode & 07777u : 0;
    }
    /// Makes `name` look as if it had not been touched for so long.
    void age(const std::string& name, std::chrono::hours by) const {
        fs::last_write_time(at(name), fs::file_time_type::clock::now() - by);
    }
    void expectRefused(const std::string& name, const std::string& word) const {
        try {
            writeFileAtomically(at(name), "new");
            FAIL() << name;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Failed);
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
        }
    }

    fs::path folder_;
};

TEST_F(PendingFileTest, ReplacedFilesKeepTheirPermissions) {
    for (const unsigned mode : {0600u, 0640u, 0664u, 0755u}) {
        write("a", "old");
        ASSERT_EQ(::chmod(at("a").c_str(), mode), 0);
        {
            const PendingFile pending(at("a"));
            // Nobody may look into a private file's successor before it is there.
            EXPECT_EQ(modeOf(pending.temporaryPath()), mode);
        }
        writeFileAtomically(at("a"), "new");
        EXPECT_EQ(read("a"), "new");
        EXPECT_EQ(modeOf(at("a")), mode);
    }
    const mode_t mask = ::umask(0027);
    writeFileAtomically(at("b"), "new");
    ::umask(mask);
    EXPECT_EQ(modeOf(at("b")), 0640u);
}

TEST_F(PendingFileTest, SymbolicLinksAreWrittenThrough) {
    fs::create_directory(folder_ / "store");
    write("store/a", "old");
    fs::create_symlink("store/a", folder_ / "near");
    fs::create_symlink(folder_ / "near", folder_ / "far");
    fs::create_symlink("store/none_yet", folder_ / "dangling");
    writeFileAtomically(at("far"), "new");
    writeFileAtomically(at("dangling"), "first");
    EXPECT_TRUE(fs::is_symlink(folder_ / "far"));
    EXPECT_TRUE(fs::is_symlink(folder_ / "near"));
    EXPECT_TRUE(fs::is_symlink(folder_ / "dangling"));
    EXPECT_EQ(read("store/a"), "new");
    EXPECT_EQ(read("store/none_yet"), "first");
    EXPECT_EQ(names(), (Strings{"dangling", "far", "near", "store"}));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "store"), {}), 2);
}

TEST_F(PendingFileTest, WhatIsNoFileIsRefused) {
    fs::create_directory(folder_ / "folder");
    fs::create_symlink("folder", folder_ / "to_folder");
    fs::create_symlink("loop_b", folder_ / "loop_a");
    fs::create_symlink("loop_a", folder_ / "loop_b");
    fs::create_symlink("/dev/full", folder_ / "full");
    ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
    write("file", "a file");
    const Strings before = names();
    expectRefused("folder", "directory");
    expectRefused("to_folder", "directory");
    expectRefused("folder/", "directory");
    expectRefused("loop_a", "circle");
    expectRefused("full", "device");
    expectRefused("pipe", "pipe");
    expectRefused("missing/a", "does not exist");
    expectRefused("file/a", "not a directory");
    expectRefused(std::string(300, 'n'), "300 bytes");
    EXPECT_EQ(names(), before);
    EXPECT_EQ(read("file"), "a file");
}

TEST_F(PendingFileTest, LongNamesAreWritten) {
    const std::string name(250, 'n');
    writeFileAtomically(at(name), "new");
    EXPECT_EQ(names(), Strings{name});
}

// Runs `body` in a process that is killed while a file is pending.
template <class Body>
pid_t killedWhilePending(const std::string& path, const Body& body) {
    int ready[2];
    if (::pipe(ready) != 0) return -1;
    const pid_t child = ::fork();
    if (child == 0) {
        PendingFile pending(path);
        writeBytes(pending.descriptor(), "half of a fi");
        static_cast<void>(::write(ready[1], "x", 1) == 1);
        ::pause();
        ::_exit(0);
    }
    char byte = 0;
    static_cast<void>(::read(ready[0], &byte, 1) == 1);
    ::close(ready[0]), ::close(ready[1]);
    body();
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    return child;
}

TEST_F(PendingFileTest, LeftoversOfTheDeadAreSweptAndThoseOfTheLivingAreNot) {
    write("a", "old");
    killedWhilePending(at("a"), [&] {
        ASSERT_EQ(names().size(), 2u);
        // The other one lives: both write beside each other.
        writeFileAtomically(at("a"), "mine");
        EXPECT_EQ(names().size(), 2u);
    });
    EXPECT_EQ(names().size(), 2u);
    // Another target's leftovers are not ours to remove.
    writeFileAtomically(at("a.b"), "another");
    EXPECT_EQ(names().size(), 3u);
    writeFileAtomically(at("a"), "new");
    EXPECT_EQ(names(), (Strings{"a", "a.b"}));
    EXPECT_EQ(read("a"), "new");
}

TEST_F(PendingFileTest, LeftoversOfFormerNamesAreSwept) {
    // Of a process number that none has, and of one that lives (this one) but has long done nothing.
    const std::string own = std::to_string(::getpid());
    const Strings dead{".a.4194305-0.tmp", "a.4194305.part", ".a." + own + "-3.tmp", "a." + own + ".part"};
    for (const std::string& name : dead) write(name, "left over");
    age(dead[2], std::chrono::hours(2)), age(dead[3], std::chrono::hours(2));
    const Strings kept{".a." + own + "-4.tmp", ".a.b.4194305-0.tmp", ".a.tmp", "a.b.part", "a.part"};
    for (const std::string& name : kept) write(name, "not ours");
    writeFileAtomically(at("a"), "new");
    Strings expected = kept;
    expected.emplace_back("a");
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(names(), expected);
}

TEST_F(PendingFileTest, AnotherMachinesFileMustBeADayOldToo) {
    const std::string name = ".a.00000000-0123456789abcdef.tmp";
    write(name, "of another machine, or of before this one started");
    writeFileAtomically(at("a"), "new");
    EXPECT_EQ(names(), (Strings{name, "a"}));
    age(name, std::chrono::hours(25));
    writeFileAtomically(at("a"), "newer");
    EXPECT_EQ(names(), Strings{"a"});
}

TEST_F(PendingFileTest, AFileThatIsLockedIsNotSwept) {
    { const PendingFile pending(at("a")); }
    const std::string old = ".a.00000000-0123456789abcdef.tmp";
    write(old, "someone's");
    age(old, std::chrono::hours(48));
    const int descriptor = ::open(at(old).c_str(), O_RDONLY);
    ASSERT_EQ(::flock(descriptor, LOCK_EX), 0);
    EXPECT_EQ(removeLeftovers(at("a")), Strings{});
    ::close(descriptor);
    EXPECT_EQ(removeLeftovers(at("a")), Strings{at(old)});
}

TEST_F(PendingFileTest, ManyWritersAtOnceLeaveOneWholeFileAndNothingElse) {
    const std::string bytes(100000, 'x');
    std::vector<std::thread> threads;
    for (int t = 0; t < 8; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 20; ++i) writeFileAtomically(at("a"), bytes);
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(names(), Strings{"a"});
    EXPECT_EQ(read("a"), bytes);
}

TEST_F(PendingFileTest, InputsThatAreNoFilesAreNamedAndDoNotWait) {
    fs::create_directory(folder_ / "folder");
    ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
    fs::create_symlink("loop", folder_ / "loop");
    const auto expect = [](const std::string& path, const std::string& word) {
        try {
            readFileBytes(path);
            FAIL() << path;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
        }
    };
    expect(at("pipe"), "pipe");
    expect("/dev/zero", "device");
    expect(at("folder"), "directory");
    expect(at("loop"), "symbolic links");
    expect(at("missing"), "No such file");
}

TEST_F(PendingFileTest, FilesReadAreRemembered) {
    write("a", "1");
    write("b", "2");
    const FilesRead all;
    {
        const FilesRead some;
        EXPECT_EQ(readFileBytes(at("b")), "2");
        EXPECT_EQ(some.paths(), Strings{at("b")});
    }
    EXPECT_EQ(readFileBytes(at("a")), "1");
    EXPECT_EQ(readFileBytes(at("b")), "2");
    EXPECT_EQ(all.paths(), (Strings{at("b"), at("a")}));
}

}  // namespace
}  // namespace photic
