#include "app/annotate.h"

#include "app/model_aim.h"
#include "app/overlays.h"
#include "scene/errors.h"

#include <array>
#include <cstdio>
#include <utility>

#include <glm/geometric.hpp>

namespace app {

namespace {

constexpr scene::Rgb8 kTextColour{255, 255, 255};

std::string sayPlace(const glm::dvec3& p) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), " at %.3f %.3f %.3f", p.x, p.y, p.z);
    return text.data();
}

/// Where a distance's label stands: clear of its line.
glm::dvec3 aboveMiddle(const glm::dvec3& a, const glm::dvec3& b, const scene::Pose& worldFromWalk) {
    return (a + b) / 2.0 + 0.05 * worldFromWalk.rotation[1];
}

void addLabel(render::Overlay& overlay, const glm::dvec3& at, const std::string& text, scene::Rgb8 colour) {
    constexpr float kReadable = 0.7f; // what was measured is to be read wherever it is
    overlay.labels.push_back({at, text, colour, 0.015f, 0, kReadable});
}

} // namespace

Annotator::Annotator(const scene::Scene& scene, const std::filesystem::path& sceneFolder)
    : scene_(scene), worldFromWalk_(inverse(scene.walkFromWorld)), accuracy_(scene), file_(sceneFolder) {
    try {
        noting_.notes = file_.read();
        noting_.older = noting_.notes.list.size();
    } catch (const scene::Failure& failure) {
        refused_ = notice_ = failure.what();
    }
}

void Annotator::update(const NotingWants& wants) {
    aimed_ = wants.aim ? nearer(scene::pick(scene_.blocks, *wants.aim, wants.shown), wants.model) : std::nullopt;
    const std::size_t before = noting_.notes.list.size();
    const bool hadStart = noting_.start.has_value();
    if (wants.undoes) takeBack();
    if (wants.presses) {
        if (!refused_.empty())
            notice_ = refused_;
        else if (!aimed_)
            notice_ = "nothing that was seen is there to note";
        else if (!aimed_->isSeen)
            notice_ = "no range was measured there: only what was seen is noted";
        else
            noting_ = press(std::move(noting_), wants.mode, *aimed_, timeNow(),
                            [&](const glm::dvec3& place, const std::optional<glm::dvec3>& other) {
                                return other ? accuracy_.ofDistance(*other, place) : accuracy_.ofPlace(place);
                            });
    }
    if (noting_.start && !hadStart) notice_ = "from" + sayPlace(*noting_.start) + ", to where?";
    if (noting_.notes.list.size() == before) return;
    if (noting_.notes.list.size() > before) {
        const Note& made = noting_.notes.list.back();
        notice_ = made.label + sayPlace(made.to);
    }
    keep();
}

void Annotator::takeBack() {
    const bool hadStart = noting_.start.has_value();
    const std::vector<Note>& list = noting_.notes.list;
    const std::string last = list.size() > noting_.older ? list.back().label : std::string();
    noting_ = undo(std::move(noting_));
    notice_ = hadStart       ? "the start of the distance is taken back"
              : last.empty() ? "nothing that was noted in this walk is left to take back"
                             : last + " is taken back";
}

void Annotator::keep() {
    try {
        file_.write(noting_.notes);
    } catch (const scene::Failure& failure) {
        notice_ = failure.what();
    }
}

std::string Annotator::takeNotice() {
    return std::exchange(notice_, {});
}

void Annotator::appendTo(render::Overlay& overlay) const {
    for (const Note& note : noting_.notes.list) {
        if (note.kind == Note::Kind::point) {
            addCross(overlay, worldFromWalk_, note.from);
            addLabel(overlay, note.from, note.label, kTextColour);
        } else if (note.kind == Note::Kind::distance) {
            addDistance(overlay, worldFromWalk_, note.from, note.to);
            addLabel(overlay, aboveMiddle(note.from, note.to, worldFromWalk_), note.label, kTextColour);
        }
    }
    const bool isSeen = aimed_ && aimed_->isSeen;
    if (aimed_)
        addAim(overlay, worldFromWalk_, aimed_->position, aimed_->normal.value_or(glm::dvec3(0)),
               isSeen ? kAllowedColour : kRefusedColour);
    if (!noting_.start) return;
    addCross(overlay, worldFromWalk_, *noting_.start, kAllowedColour);
    if (!isSeen) return;
    addDistance(overlay, worldFromWalk_, *noting_.start, aimed_->position, kAllowedColour);
    const std::string text = distanceText(glm::distance(*noting_.start, aimed_->position), std::nullopt);
    addLabel(overlay, aboveMiddle(*noting_.start, aimed_->position, worldFromWalk_), text, kAllowedColour);
}

} // namespace app
