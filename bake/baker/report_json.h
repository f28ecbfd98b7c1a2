// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bake/report/bake_report.h"
#include "bake/scene/scene.h"

namespace photic {

nlohmann::ordered_json toJson(const PowerLedger& ledger);
nlohmann::ordered_json toJson(const PathLedger& ledger);
nlohmann::ordered_json toJson(const OptionValue& value);
nlohmann::ordered_json toJson(const ReceiverError& error);
/// All of a bake's report (docs/schemas/report.md), without the scene's part.
nlohmann::ordered_json toJson(const BakeReport& report);

/// What receivers' look-ups are off by, as the `receiver_errors` metadata holds it: a JSON array.
std::string receiverErrorsText(const std::vector<ReceiverError>& errors);
/// Those of such a text; none where it is not one.
std::vector<ReceiverError> readReceiverErrors(const std::string& text);

/// Both ledgers as the `ledger` metadata holds them.
std::string ledgerText(const BakeReport& report);
/// The ledgers of a `ledger` metadata. @throws Error{Input} when it is not one
void readLedger(const std::string& text, PowerLedger& power, PathLedger& path);

/// Text of a document: names that are not UTF-8 are made so, numbers that are not finite become null.
/// @param indent  spaces a level; -1: one line
std::string dump(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace photic
