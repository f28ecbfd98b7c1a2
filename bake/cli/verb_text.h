// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace photic::cli {

/// An option or an argument as help, the man page and completions tell it.
struct OptionText {
    std::vector<std::string> names;  ///< "-o", "--output"; of an argument its name alone
    std::string value;               ///< what stands for its value: "FILE", "N", "bar|json|none"; empty for a switch
    std::string help;
    bool argument = false, required = false, repeats = false;

    /// The words that it can be, where there are few.
    std::vector<std::string> choices() const;
};

/// A verb as help, the man page and completions tell it.
struct VerbText {
    std::string name, summary;
    std::vector<std::string> examples;  ///< whole lines
    std::vector<OptionText> options;
    std::string notes;  ///< more for its help page; lines that begin with spaces are kept as they are
};

/// The program: its verbs in order, and what all of them share.
struct ProgramText {
    std::string summary, exit_codes;
    std::vector<VerbText> verbs;
};

/// How a page is laid out.
struct PageStyle {
    int columns = 80;
    bool colour = false;
};
/// That of the terminal at stdout.
PageStyle pageStyle();

/// The page of `photic --help`.
std::string helpPage(const ProgramText& program, const PageStyle& style);
/// The page of `photic help VERB`.
std::string helpPage(const VerbText& verb, const PageStyle& style);
/// photic.1, in roff.
std::string manPage(const ProgramText& program);
/// A script of completions for bash, zsh or fish. @throws Error{Usage} for another shell
std::string completions(const ProgramText& program, const std::string& shell);

}  // namespace photic::cli
