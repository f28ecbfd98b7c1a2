// SPDX-License-Identifier: Apache-2.0
// The man page and the completions, from the same table as the help.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>
#include <string_view>

#include "bake/baker/version.h"
#include "bake/cli/verb_text.h"
#include "bake/report/error.h"

namespace photic::cli {

namespace {

std::string replaced(std::string text, std::string_view what, std::string_view by) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
        text.replace(at, what.size(), by);
    return text;
}

/// Text of a roff page: its backslashes and dashes are themselves, and no line begins with a command.
std::string roff(const std::string& text) {
    std::string out = replaced(replaced(text, "\\", "\\\\"), "-", "\\-");
    return out.starts_with('.') || out.starts_with('\'') ? fmt::format("\\&{}", out) : out;
}

std::string roffOption(const OptionText& option) {
    std::string names;
    for (const std::string& name : option.names) {
        if (!names.empty()) names += ", ";
        names += (option.argument ? "\\fI" : "\\fB") + roff(name) + "\\fR";
    }
    if (!option.value.empty() && !option.argument) names += " \\fI" + roff(option.value) + "\\fR";
    return ".TP\n" + names + "\n" + roff(option.help) + "\n";
}

/// Quoted for a shell: 'it'\''s'.
std::string quoted(const std::string& text) { return fmt::format("'{}'", replaced(text, "'", "'\\''")); }

/// Whether a value is the name of a file or folder.
bool isPath(const OptionText& option) { return option.value == "FILE" || option.value == "FOLDER"; }

std::string bashCompletions(const ProgramText& program) {
    std::string verbs, cases;
    for (const VerbText& verb : program.verbs) {
        verbs += (verbs.empty() ? "" : " ") + verb.name;
        std::string words, values;
        for (const OptionText& option : verb.options) {
            if (option.argument) continue;
            for (const std::string& name : option.names) words += (words.empty() ? "" : " ") + name;
            if (option.value.empty()) continue;
            const auto choices = option.choices();
            values += fmt::format("                {}) {} ;;\n", fmt::join(option.names, "|"),
                                  !choices.empty() ? fmt::format("COMPREPLY=($(compgen -W {} -- \"$cur\")); return",
                                                                 quoted(fmt::format("{}", fmt::join(choices, " "))))
                                  : isPath(option) ? std::string("COMPREPLY=($(compgen -f -- \"$cur\")); return")
                                                   : std::string("return"));
        }
        cases += fmt::format("        {})\n", verb.name);
        if (!values.empty()) cases += "            case \"$prev\" in\n" + values + "            esac\n";
        cases += fmt::format("            words={} ;;\n", quoted(words));
    }
    return "# bash completion for photic; made by photic completions bash\n"
           "_photic() {\n"
           "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} words=''\n"
           "    COMPREPLY=()\n"
           "    if [ \"$COMP_CWORD\" -eq 1 ] || { [ \"$COMP_CWORD\" -eq 2 ] && [ \"$prev\" = help ]; }; then\n"
           "        COMPREPLY=($(compgen -W " +
           quoted(verbs + " help --help --version") +
           " -- \"$cur\"))\n        return\n    fi\n    case \"${COMP_WORDS[1]}\" in\n" + cases +
           "    esac\n"
           "    if [[ $cur == -* ]]; then COMPREPLY=($(compgen -W \"$words\" -- \"$cur\")); else "
           "COMPREPLY=($(compgen -f -- \"$cur\")); fi\n"
           "}\n"
           "complete -o filenames -F _photic photic\n";
}

/// A help text within zsh's [brackets] or a description after a colon.
std::string zshText(const std::string& text) {
    return replaced(replaced(replaced(replaced(text, "\\", "\\\\"), "[", "\\["), "]", "\\]"), ":", "\\:");
}

std::string zshOption(const OptionText& option) {
    std::string action;
    const auto choices = option.choices();
    if (!choices.empty())
        action = fmt::format(":{}:({})", zshText(option.names.back()), fmt::join(choices, " "));
    else if (isPath(option) || option.argument)
        action = fmt::format(":{}:_files", zshText(option.value));
    else if (!option.value.empty())
        action = fmt::format(":{}: ", zshText(option.value));
    if (option.argument) return quoted((option.repeats ? "*" : "") + action);
    std::string specs;
    for (const std::string& name : option.names) {
        if (!specs.empty()) specs += " ";
        specs += quoted(fmt::format("{}{}[{}]{}", option.repeats ? "*" : "", name, zshText(option.help), action));
    }
    return specs;
}

std::string zshCompletions(const ProgramText& program) {
    std::string verbs, cases;
    for (const VerbText& verb : program.verbs) {
        verbs += "        " + quoted(verb.name + ":" + zshText(verb.summary)) + "\n";
        std::string options;
        for (const OptionText& option : verb.options) options += " \\\n                " + zshOption(option);
        if (options.empty()) options = " '*:file:_files'";
        cases += fmt::format("            {})\n            _arguments{} ;;\n", verb.name, options);
    }
    return "#compdef photic\n"
           "# zsh completion for photic; made by photic completions zsh\n"
           "_photic() {\n"
           "    local -a verbs\n"
           "    verbs=(\n" +
           verbs +
           "        'help:Show the help of a verb'\n    )\n"
           "    if (( CURRENT == 2 )); then\n"
           "        _describe 'verb' verbs\n"
           "    else\n"
           "        local verb=$words[2]\n"
           "        shift words\n"
           "        (( CURRENT-- ))\n"
           "        case $verb in\n"
           "            help) _describe 'verb' verbs ;;\n" +
           cases +
           "        esac\n    fi\n}\n"
           "if [ \"$funcstack[1]\" = \"_photic\" ]; then _photic \"$@\"; else compdef _photic photic; fi\n";
}

std::string fishCompletions(const ProgramText& program) {
    std::string text = "# fish completion for photic; made by photic completions fish\n";
    for (const VerbText& verb : program.verbs) {
        text += fmt::format("complete -c photic -n __fish_use_subcommand -f -a {} -d {}\n", verb.name,
                            quoted(verb.summary));
        for (const OptionText& option : verb.options) {
            if (option.argument) continue;
            std::string line =
                fmt::format("complete -c photic -n {}", quoted("__fish_seen_subcommand_from " + verb.name));
            for (const std::string& name : option.names)
                line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
            const auto choices = option.choices();
            if (!choices.empty())
                line += " -x -a " + quoted(fmt::format("{}", fmt::join(choices, " ")));
            else if (isPath(option))
                line += " -r -F";
            else if (!option.value.empty())
                line += " -x";
            text += line + " -d " + quoted(option.help) + "\n";
        }
    }
    return text;
}

}  // namespace

std::string manPage(const ProgramText& program) {
    std::string page =
        fmt::format(".TH PHOTIC 1 \"\" \"{}\" \"User commands\"\n.SH NAME\nphotic \\- {}\n", programName(),
                    roff("bake the light that water, glass and mirrors focus into volumes"));
    page += ".SH SYNOPSIS\n\\fBphotic\\fR \\fIVERB\\fR [\\fIOPTIONS\\fR] ...\n.br\n\\fBphotic help\\fR \\fIVERB\\fR\n";
    page += ".SH DESCRIPTION\n" + roff(program.summary) + "\n";
    for (const VerbText& verb : program.verbs) {
        page += ".SH \"PHOTIC " + verb.name + "\"\n" + roff(verb.summary) + ".\n";
        for (const OptionText& option : verb.options) page += roffOption(option);
        if (!verb.examples.empty()) page += ".PP\n.nf\n";
        for (const std::string& example : verb.examples) page += "    " + roff(example) + "\n";
        if (!verb.examples.empty()) page += ".fi\n";
        if (verb.notes.empty()) continue;
        page += ".PP\n.nf\n";
        std::istringstream notes(verb.notes);
        for (std::string line; std::getline(notes, line);) page += roff(line) + "\n";
        page += ".fi\n";
    }
    return page + ".SH \"EXIT STATUS\"\n" + roff(program.exit_codes) + "\n";
}

std::string completions(const ProgramText& program, const std::string& shell) {
    if (shell == "bash") return bashCompletions(program);
    if (shell == "zsh") return zshCompletions(program);
    if (shell == "fish") return fishCompletions(program);
    throw Error(ErrorCode::Usage,
                fmt::format("no completions for the shell '{}'; there are bash, zsh and fish", shell));
}

}  // namespace photic::cli
