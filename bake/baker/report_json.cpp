// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/report_json.h"

#include <nlohmann/json.hpp>
#include <variant>

#include "bake/report/error.h"

namespace photic {

namespace {

using Json = nlohmann::ordered_json;

/// The ledger's terms, in the order of the equation.
struct PowerTerm {
    const char* name;
    double PowerLedger::*value;
};
constexpr PowerTerm kPowerTerms[] = {{"emitted", &PowerLedger::emitted},
                                     {"reflected", &PowerLedger::reflected},
                                     {"absorbed_medium", &PowerLedger::absorbed_medium},
                                     {"scattered", &PowerLedger::scattered},
                                     {"absorbed_surface", &PowerLedger::absorbed_surface},
                                     {"received", &PowerLedger::received},
                                     {"escaped", &PowerLedger::escaped},
                                     {"dropped", &PowerLedger::dropped},
                                     {"culled", &PowerLedger::culled}};

}  // namespace

Json toJson(const PowerLedger& ledger) {
    Json json = Json::object();
    for (const PowerTerm& term : kPowerTerms) json[term.name] = ledger.*term.value;
    json["imbalance"] = ledger.imbalance();
    return json;
}

Json toJson(const PathLedger& ledger) {
    return {{"deposited", ledger.deposited}, {"expected", ledger.expected}, {"imbalance", ledger.imbalance()}};
}

Json toJson(const ReceiverError& error) {
    return {{"name", error.name}, {"detail", error.detail}, {"relative_l1", error.relative_l1}, {"share", error.share}};
}

Json toJson(const OptionValue& value) {
    return std::visit([](const auto& v) { return Json(v); }, value);
}

Json toJson(const BakeReport& report) {
    Json seconds = Json::object();
    for (const auto& [stage, time] : report.seconds) seconds[stage] = seconds.value(stage, 0.0) + time;
    Json receivers = Json::array();
    for (const ReceiverError& error : report.receivers) receivers.push_back(toJson(error));
    Json json{{"power", toJson(report.power)},
              {"path", toJson(report.path)},
              {"reference_irradiance", report.reference_irradiance},
              {"tubes", report.tubes},
              {"corner_rays", report.corner_rays},
              {"needed_voxels", report.needed_voxels},
              {"active_voxels", report.active_voxels},
              {"field_bytes", report.field_bytes},
              {"instruction_set", report.instruction_set},
              {"threads", report.threads},
              {"seconds", seconds},
              {"skipped", report.skipped},
              {"receivers", receivers},
              {"advice", report.advice},
              {"warnings", report.warnings}};
    if (report.given_up)
        json["given_up"] = {{"outlines", report.given_up->outlines},
                            {"turned", report.given_up->turned},
                            {"events", report.given_up->events},
                            {"threshold", report.given_up->threshold}};
    if (report.astride) json["astride"] = *report.astride;
    if (report.arrivals)
        json["arrivals"] = {{"several", report.arrivals->several},
                            {"strongest", report.arrivals->strongest},
                            {"left_out", report.arrivals->left_out},
                            {"rmse", report.arrivals->rmse}};
    return json;
}

std::string receiverErrorsText(const std::vector<ReceiverError>& errors) {
    Json json = Json::array();
    for (const ReceiverError& error : errors) json.push_back(toJson(error));
    return dump(json);
}

std::vector<ReceiverError> readReceiverErrors(const std::string& text) {
    std::vector<ReceiverError> errors;
    try {
        for (const Json& error : Json::parse(text))
            errors.push_back({error.at("name").get<std::string>(), error.at("detail").get<double>(),
                              error.at("relative_l1").get<double>(), error.at("share").get<double>()});
    } catch (const Json::exception&) {
        errors.clear();  // written by something else
    }
    return errors;
}

std::string ledgerText(const BakeReport& report) {
    return dump({{"power", toJson(report.power)}, {"path", toJson(report.path)}});
}

void readLedger(const std::string& text, PowerLedger& power, PathLedger& path) {
    try {
        const Json json = Json::parse(text);
        for (const PowerTerm& term : kPowerTerms) power.*term.value = json.at("power").at(term.name).get<double>();
        path.deposited = json.at("path").at("deposited").get<double>();
        path.expected = json.at("path").at("expected").get<double>();
    } catch (const Json::exception& error) {
        throw Error(ErrorCode::Input,
                    std::string("the volume's ledger cannot be read (") + error.what() + "); bake it again",
                    "photic:ledger");
    }
}

std::string dump(const Json& json, int indent) { return json.dump(indent, ' ', false, Json::error_handler_t::replace); }

}  // namespace photic
