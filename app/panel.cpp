#include "app/panel.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <imgui.h>

namespace app {

namespace {

const char* eyeName(int eye) {
    if (eye == render::kWholeFrame) return "";
    return eye == 0 ? "left" : "right";
}

void drawTimes(const char* title, const std::vector<render::StepTime>& times) {
    double sum = 0;
    for (const render::StepTime& time : times)
        sum += time.milliseconds;
    if (!ImGui::TreeNodeEx(title, 0, "%s  %.1f ms", title, sum)) return;
    if (ImGui::BeginTable(title, 3)) {
        for (const render::StepTime& time : times) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(time.step);
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(eyeName(time.eye));
            ImGui::TableNextColumn();
            ImGui::Text("%.2f", time.milliseconds);
        }
        ImGui::EndTable();
    }
    ImGui::TreePop();
}

void drawFacts(const WalkFacts& facts) {
    ImGui::TextWrapped("%s", facts.display.c_str());
    if (!facts.isTracked) ImGui::TextColored({1, 0.6f, 0.2f, 1}, "the head is not tracked");
    ImGui::Text("%.1f frames/s", facts.framesPerSecond);
    if (!facts.given.empty()) ImGui::Text("to hold the rate: %s", facts.given.c_str());
    ImGui::Text("walk space %.2f, %.2f, %.2f m   %.1f m/s", facts.place.x, facts.place.y, facts.place.z, facts.speed);
    if (std::abs(facts.scale - 1) > 1e-9) ImGui::Text("world 1 : %.3g", facts.scale);
    std::uint64_t samples = 0;
    std::uint32_t drawn = 0, tested = 0;
    for (const render::EyeCounts& eye : facts.stats.eyes)
        samples += eye.samplesDrawn, drawn += eye.tilesDrawn, tested += eye.tilesTested;
    ImGui::Text("tiles %u of %u, samples %.2f M", drawn, tested, static_cast<double>(samples) * 1e-6);
    drawTimes("processor", facts.stats.cpu);
    drawTimes("device", facts.stats.gpu);
}

void drawKnobs(PanelState& state, Knobs& knobs) {
    int warp = static_cast<int>(knobs.quality.warp);
    ImGui::RadioButton("points", &warp, static_cast<int>(render::Warp::points));
    ImGui::SameLine();
    ImGui::RadioButton("mesh", &warp, static_cast<int>(render::Warp::mesh));
    ImGui::SameLine();
    ImGui::RadioButton("splats", &warp, static_cast<int>(render::Warp::splats));
    knobs.quality.warp = static_cast<render::Warp>(warp);
    ImGui::SameLine();
    ImGui::Checkbox("blended", &knobs.quality.isBlended);
    ImGui::SliderInt("widest footprint", &knobs.quality.maxFootprint, 1, 16);
    float baseline = static_cast<float>(knobs.quality.preference.nearBaseline);
    if (ImGui::SliderFloat("near baseline", &baseline, 0, 0.3f, "%.2f"))
        knobs.quality.preference.nearBaseline = baseline;
    float scale = static_cast<float>(knobs.resolutionScale);
    if (ImGui::SliderFloat("resolution", &scale, 0.1f, 1, "%.2f"))
        knobs.resolutionScale = std::clamp(static_cast<double>(scale), 0.1, 1.0);

    ImGui::Checkbox("the unseen", &knobs.quality.showUnseen);
    ImGui::SameLine();
    ImGui::Checkbox("tint what was not measured", &knobs.quality.marksUnmeasured);
    ImGui::Checkbox("cameras", &knobs.showsCameras);
    ImGui::SameLine();
    ImGui::Checkbox("cells", &knobs.showsCells);
    ImGui::SameLine();
    ImGui::Checkbox("floor", &knobs.settings.showsFloorGrid);
    int view = static_cast<int>(state.view);
    ImGui::RadioButton("walker", &view, 0);
    ImGui::SameLine();
    ImGui::RadioButton("left eye", &view, 1);
    ImGui::SameLine();
    ImGui::RadioButton("both eyes", &view, 2);
    state.view = static_cast<PanelState::View>(view);
}

bool slide(const char* title, double& value, double least, double most, const char* format) {
    float shown = static_cast<float>(value);
    if (!ImGui::SliderFloat(title, &shown, static_cast<float>(least), static_cast<float>(most), format)) return false;
    value = std::clamp(static_cast<double>(shown), least, most);
    return true;
}

void drawWalking(PanelState& state, Knobs& knobs) {
    if (!ImGui::TreeNode("walking")) return;
    input::LocomotionSettings& settings = knobs.settings.locomotion;
    for (const double degrees : {15.0, 30.0, 45.0, 0.0}) {
        const std::string title = degrees > 0 ? "turn " + std::to_string(static_cast<int>(degrees)) : "smoothly";
        if (ImGui::RadioButton(title.c_str(), settings.snapDegrees == degrees)) settings.snapDegrees = degrees;
        if (degrees > 0 && degrees < 45) ImGui::SameLine(); // four do not fit
    }
    slide("turning", settings.turnDegreesPerSecond, 10, 360, "%.0f degrees/s");
    slide("speed", settings.metresPerSecond, 0.1, 20, "%.1f m/s");
    slide("eye height", knobs.settings.eyeHeightMetres, 0.1, 3, "%.2f m");
    ImGui::Checkbox("fly where one looks", &settings.flies);
    ImGui::Checkbox("darken the rim in motion", &settings.hasVignette);
    if (ImGui::Button("start here")) state.startsHere = true;
    ImGui::TreePop();
}

void drawHelp() {
    if (!ImGui::TreeNode("keys")) return;
    if (ImGui::BeginTable("keys", 2)) {
        ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed);
        ImGui::TableSetupColumn("does", ImGuiTableColumnFlags_WidthStretch);
        for (const input::KeyHelp& line : input::keyHelp()) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(line.keys);
            ImGui::TableNextColumn();
            ImGui::TextWrapped("%s", line.does);
        }
        ImGui::EndTable();
    }
    ImGui::TreePop();
}

} // namespace

void drawPanel(const WalkFacts& facts, PanelState& state, Knobs& knobs) {
    if (state.isFilming) {
        ImGui::SetNextWindowPos({ImGui::GetIO().DisplaySize.x - 70, 8});
        ImGui::Begin("film", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize);
        ImGui::TextColored({1, 0.3f, 0.3f, 1}, "film");
        ImGui::End();
    }
    state.area = {};
    if (!state.isOpen) return;
    ImGui::SetNextWindowPos({8, 8}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({340, 480}, ImGuiCond_FirstUseEver);
    const bool isUnfolded = ImGui::Begin("Revisit", &state.isOpen);
    const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    state.area = {at.x, at.y, size.x, size.y};
    if (isUnfolded) {
        ImGui::PushItemWidth(170);
        drawFacts(facts);
        ImGui::Separator();
        drawKnobs(state, knobs);
        drawWalking(state, knobs);
        ImGui::Separator();
        drawHelp();
        ImGui::PopItemWidth();
        if (!facts.notice.empty()) ImGui::TextWrapped("%s", facts.notice.c_str());
    }
    ImGui::End();
}

} // namespace app
