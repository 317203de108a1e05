#include "app/walk.h"

#include "app/overlays.h"
#include "app/say.h"
#include "app/stage_store.h"

#include "input/path.h"
#include "scene/coverage_levels.h"
#include "scene/errors.h"
#include "scene/pick.h"
#include "xr/check.h"
#include "xr/window.h"

#include <algorithm>
#include <csignal>
#include <utility>

#include <glm/geometric.hpp>

namespace app {

namespace {

using nlohmann::json;

volatile std::sig_atomic_t wasAskedToEnd = 0;

/// So long nobody is told that controllers are missing: they take a while to be found.
constexpr int kPatientFrames = 600;

/// Images from nearer to each other than this are from one place, metres.
constexpr double kSameStand = 1e-3;

/// The head's pose along a path file.
xr::Headless::Path pathOf(const std::filesystem::path& file, const scene::Pose& walkFromWorld) {
    input::RecordedPath recorded = input::readPath(file);
    if (recorded.keys.size() > 1 && recorded.keys.front().seconds == recorded.keys.back().seconds)
        throw scene::Failure("says of no pose when it is reached", file, "give each its t in seconds");
    if (recorded.space == input::PathSpace::world)
        for (input::PathKey& key : recorded.keys)
            key.spaceFromHead = walkFromWorld * key.spaceFromHead;
    return input::SmoothPath(recorded.keys);
}

/// A broken one is told of and passed over: the walk begins where the scene does.
std::optional<input::StartPose> readStartOf(const scene::Scene& scene) {
    try {
        return input::readStart(scene.folder / input::kStartFile);
    } catch (const scene::Failure& failure) {
        say(failure.what());
        return std::nullopt;
    }
}

const char* textOf(input::Refusal refusal) {
    switch (refusal) {
    case input::Refusal::unseen:
        return "nobody saw a floor there";
    case input::Refusal::tooFar:
        return "too far";
    case input::Refusal::tooSteep:
        break;
    }
    return "too steep to stand on";
}

/// A ray from an eye through a place in its picture: a pose that looks along it.
scene::Pose aimThrough(const scene::View& eye, const glm::dvec2& pixel) {
    const scene::Camera& c = eye.camera;
    const glm::dvec3 inCamera{(pixel.x - c.cx) / c.fx, (pixel.y - c.cy) / c.fy, 1};
    const glm::dvec3 back = -glm::normalize(eye.worldFromEye.rotation * inCamera);
    const glm::dvec3 right =
        glm::normalize(eye.worldFromEye.rotation[0] - glm::dot(eye.worldFromEye.rotation[0], back) * back);
    return {glm::dmat3(right, glm::cross(back, right), back), eye.worldFromEye.translation};
}

} // namespace

Knobs Walk::knobsOf(const WalkOptions& options) {
    Knobs knobs;
    knobs.quality = qualityOf(options.draw);
    knobs.settings = options.settings;
    return knobs;
}

void Walk::askToEnd() {
    wasAskedToEnd = 1;
}

void Walk::forgetAskedToEnd() {
    wasAskedToEnd = 0;
}

bool Walk::isAskedToEnd() const {
    return wasAskedToEnd != 0 || (options_.frames > 0 && frame_ >= static_cast<std::size_t>(options_.frames));
}

Walk::Walk(const scene::Scene& scene, const WalkOptions& options, DeskSide* deskSide)
    : scene_(scene), drawnScene_(scene, options.draw), options_(options), deskSide_(deskSide), knobs_(knobsOf(options)),
      worldFromWalk_(inverse(scene.walkFromWorld)), record_(options), selection_(scene) {
    drawnScene_.mayShowUnseen = true; // the walker may ask for it at any time
    if (options.framesPerSecond > 0 && options.holdsRate.value_or(!options.isHeadless))
        governed_.emplace(options.framesPerSecond);
    if (!options.path.empty()) path_ = pathOf(options.path, scene.walkFromWorld);
    if (!options.isHeadless) {
        start_ = readStartOf(scene);
        annotator_.emplace(scene, scene.folder);
        findModels();
    }
    if (start_) setHome();
    surroundings_.hit = [this](const glm::dvec3& from, const glm::dvec3& d) { return hit(from, d); };
    for (const scene::SceneImage& image : scene.images) {
        const scene::Pose head = scene.walkFromWorld * image.worldFromCamera * scene::headFromCamera();
        // The faces of a cube around a scanner are one place.
        if (surroundings_.captures.empty() ||
            glm::distance(surroundings_.captures.back().translation, head.translation) > kSameStand)
            surroundings_.captures.push_back(head);
    }
}

void Walk::findModels() {
    if (!drawnScene_.polygons) return;
    try {
        models_.emplace(*drawnScene_.polygons);
    } catch (const scene::Failure& failure) { // panes of glass alone, or there is no memory
        sayNote(std::string("aims pass through --polygons: ") + failure.what());
    }
}

void Walk::say(const std::string& notice) {
    sayPlainly(notice);
    facts_.notice = notice;
}

void Walk::drawFrame(WalkStage& stage, xr::ViewSource& source, const xr::Frame& frame) {
    frameBegan_ = std::chrono::steady_clock::now();
    if (frame.refreshesMissed)
        refreshesMissed_ = refreshesMissed_.value_or(0) + (wasWarmedUp_ ? 0 : *frame.refreshesMissed);
    wasWarmedUp_ = false;
    advance(stage, source, frame);
    drawSomehow(stage, source, frame);
    xr::Frame shown = frame;
    shown.pictureWidth = stats_.picture.width, shown.pictureHeight = stats_.picture.height;
    source.end(shown);
    if (governed_) governed_->tell(stats_, stage.device().isProcessor());
    const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - frameBegan_;
    report_.add(stats_, passed.count());
    ++frame_;
}

void Walk::drawSomehow(WalkStage& stage, xr::ViewSource& source, const xr::Frame& frame) {
    while (true) {
        try {
            return draw(stage, source, frame);
        } catch (const render::OutOfMemory& failure) {
            if (!giveUpMore(drawn_, failure, givenUp_) && !stage.giveUpFinestCoverage(failure)) throw;
        } catch (const render::DeviceLost& loss) {
            // A headset's session ends with its device, and takes this frame along.
            if (stage.headset() != nullptr) throw;
            losses_.tell(loss);
            stage.remakeDevice(drawnScene_);
        }
    }
}

input::Wants Walk::hearWants(WalkStage& stage, const xr::ViewSource& source, const xr::Frame& frame) {
    input::Wants wants;
    if (deskSide_ != nullptr) {
        const input::DeskSays says = deskSide_->desk.hear();
        startsHere_ = says.said(input::Command::startHere);
        if (isDesk(source)) {
            wants = says.wants;
            // The mouse is a hand: what it points at lies along a ray from the eye through the cursor.
            const scene::View& eye = frame.eyes[0];
            const glm::dvec2 pixel{says.cursor.x * eye.camera.width, says.cursor.y * eye.camera.height};
            input::Hand& hand = wants.hands[1];
            hand.isTracked = true;
            hand.trackingFromAim = aimThrough(eye, pixel);
            hand.trackingFromGrip = hand.trackingFromAim;
            hand.picks = says.picks, hand.teleports = says.teleports;
        } else {
            // Whoever helps at the desk may bring the wearer somewhere, but not push them along.
            wants.home = says.wants.home, wants.recentre = says.wants.recentre;
            wants.next = says.wants.next, wants.previous = says.wants.previous;
            wants.undo = says.wants.undo;
        }
    }
    if (!isDesk(source) && stage.actions() != nullptr) {
        stage.actions()->read(stage.headset()->displayTime(), wants);
        sayControllers(*stage.actions());
    }
    wants.trackingFromHead = frame.trackingFromHead;
    wants.isHeadTracked = frame.isTracked;
    wants.seconds = seconds_ - std::exchange(wentAt_, seconds_);
    return wants;
}

void Walk::sayControllers(const input::Actions& actions) {
    constexpr std::array kNames{"left", "right"};
    for (std::size_t hand = 0; hand < input::kHands; ++hand) {
        const std::string& held = actions.controller(hand);
        if (held == controllers_[hand]) continue;
        controllers_[hand] = held;
        say(std::string(kNames[hand]) + " hand: " + (held.empty() ? "no controller" : held));
    }
    // Runtimes make unknown controllers look like known ones where they can; where they cannot, they name none.
    if (framesWithoutController_ <= kPatientFrames && controllers_[0].empty() && controllers_[1].empty() &&
        framesWithoutController_++ == kPatientFrames)
        say("no controller that is known: switch one on, or bind it in the runtime's settings; the path or the desk's "
            "keys (home, recentre, next) lead meanwhile");
}

void Walk::setHome() {
    surroundings_.homeFeet = start_->feet;
    surroundings_.homeHeading = start_->heading, surroundings_.homeScale = start_->scale;
}

void Walk::startHere() {
    start_ =
        input::StartPose{{facts_.place.x, locomotion_.rig.origin.y, facts_.place.z}, heading_, locomotion_.rig.scale};
    setHome();
    try {
        writeWhole(scene_.folder / input::kStartFile, input::textOf(*start_));
        say("walks through this scene begin here");
    } catch (const scene::Failure& failure) {
        say("revisit: " + std::string(failure.what()));
    }
}

void Walk::tellTime(const xr::ViewSource& source, const xr::Frame& frame) {
    if (clockOf_ != &source || frame.seconds < frameSeconds_) {
        // Another source counts from another beginning; what passed between them has passed.
        const auto now = std::chrono::steady_clock::now();
        if (clockOf_ == nullptr) began_ = now;
        const double passed = std::chrono::duration<double>(now - began_).count();
        clockOffset_ = std::max(seconds_, clockOf_ == nullptr ? 0.0 : passed) - frame.seconds;
        if (options_.isHeadless) clockOffset_ = 0;
        clockOf_ = &source;
    }
    frameSeconds_ = frame.seconds;
    seconds_ = frame.seconds + clockOffset_;
}

void Walk::go(WalkStage& stage, const xr::ViewSource& source, const xr::Frame& frame) {
    const scene::Pose& head = frame.trackingFromHead;
    // Where a head that is not known stands would be made up.
    if (frame.isTracked) {
        if (wasAtDesk_ && *wasAtDesk_ != isDesk(source)) {
            // Whoever goes on elsewhere goes on from the same place, standing on the same floor.
            const glm::dvec3 feet{facts_.place.x, locomotion_.rig.origin.y, facts_.place.z};
            locomotion_ = input::brought(locomotion_, head, feet, heading_, locomotion_.rig.scale);
        }
        wasAtDesk_ = isDesk(source);
        if (!hasBegun_ && !options_.isHeadless && start_)
            locomotion_ = input::brought(locomotion_, head, start_->feet, start_->heading, start_->scale);
        if (!hasBegun_ && !options_.isHeadless && knobs_.quality.showUnseen && !scene_.coverage)
            say("what nobody saw looks empty: this scene does not say where that is (build --coverage)");
        hasBegun_ = true;
    }
    const input::Wants wants = hearWants(stage, source, frame);
    if (options_.isHeadless) return; // the path is the head's
    if (path_) {
        if (const auto led = path_(seconds_)) {
            if (!firstHead_) firstHead_ = head;
            locomotion_.rig = input::rigWithHeadAt(*firstHead_, led->translation, input::headingOf(led->rotation), 1);
        }
    } else {
        locomotion_ = input::step(locomotion_, wants, knobs_.settings.locomotion, surroundings_);
    }
    note(wants, isDesk(source));
    hands_ = wants.hands;
}

/// The left hand sets points, the right one distances; at the desk the Shift key says which.
void Walk::note(const input::Wants& wants, bool isAtDesk) {
    NotingWants noting;
    noting.undoes = wants.undo;
    noting.shown = pickOptions();
    for (std::size_t i = 0; i < input::kHands; ++i) {
        const input::Hand& hand = wants.hands[i];
        const bool wasHeld = hands_[i].picks && hands_[i].isTracked;
        if (!hand.isTracked || (!hand.picks && !wasHeld) || noting.aim) continue;
        const scene::Pose worldFromAim = worldFromWalk_ * locomotion_.rig.toWalk(hand.trackingFromAim);
        noting.aim = scene::Ray{worldFromAim.translation, -worldFromAim.rotation[2]};
        noting.presses = !hand.picks;
        // What it shall be is said when it is pressed: who lets go of a key and a button means to do both at once.
        if (!wasHeld) pressMeasures_ = wants.hurries;
        const bool measures = isAtDesk ? pressMeasures_ : i == 1;
        noting.mode = measures ? NoteMode::distances : NoteMode::points;
    }
    if (noting.aim && models_) noting.model = models_->meet(*noting.aim);
    annotator_->update(noting);
    if (const std::string notice = annotator_->takeNotice(); !notice.empty()) say(notice);
}

const scene::Coverage* Walk::findShownUnseen(const WalkStage& stage) {
    if (!knobs_.quality.showUnseen || stage.coverage() == nullptr) return nullptr;
    const int drawn = stage.coverage()->levels();
    if (drawn != coarserLevels_) {
        coarserLevels_ = drawn;
        coarser_.reset();
        if (drawn < scene::levelsOf(*scene_.coverage)) coarser_ = scene::coarsened(*scene_.coverage, drawn);
    }
    return coarser_ ? &*coarser_ : &*scene_.coverage;
}

scene::PickOptions Walk::pickOptions() const {
    scene::PickOptions options;
    options.shownGuesses = knobs_.quality.preference;
    options.shownUnseen = shownUnseen_;
    options.unseenPocketMetres = knobs_.quality.unseenPocketMetres;
    return options;
}

std::optional<input::Surface> Walk::hit(const glm::dvec3& from, const glm::dvec3& direction) const {
    const scene::Ray ray{worldFromWalk_ * from, worldFromWalk_.rotation * direction};
    const std::optional<scene::Pick> pick = scene::pick(scene_.blocks, ray, pickOptions());
    const std::optional<scene::Pick> model = models_ ? models_->meet(ray) : std::nullopt;
    // What has no normal is no floor: nor are models, which nobody scanned.
    if (model && (!pick || !pick->isSeen || model->distanceMetres < pick->distanceMetres))
        return input::Surface{scene_.walkFromWorld * model->position, glm::dvec3(0)};
    if (!pick || !pick->isSeen) return std::nullopt;
    const glm::dvec3 normal = pick->normal ? scene_.walkFromWorld.rotation * *pick->normal : glm::dvec3(0);
    return input::Surface{scene_.walkFromWorld * pick->position, normal};
}

void Walk::fillOverlay(const xr::ViewSource& source) {
    overlay_ = {};
    // A window on the desk fills no field of view: it makes nobody sick.
    if (!isDesk(source)) overlay_.vignette = static_cast<float>(locomotion_.vignette);
    if (knobs_.settings.showsFloorGrid) addFloorGrid(overlay_, worldFromWalk_, facts_.place, locomotion_.rig.origin.y);
    if (knobs_.showsCameras) addCameras(overlay_, scene_.images, worldFromWalk_ * facts_.place);
    if (knobs_.showsCells) addCells(overlay_, worldFromWalk_, selection_, worldFromWalk_ * facts_.place);
    if (const std::optional<input::TeleportTarget>& target = locomotion_.target) {
        const std::array beam{worldFromWalk_ * target->from, worldFromWalk_ * target->to};
        addTeleport(overlay_, beam, worldFromWalk_.rotation * glm::dvec3(0, 1, 0), target->isAllowed(),
                    0.25 * locomotion_.rig.scale);
        if (target->refusal)
            overlay_.labels.push_back(
                {.at = beam[1], .text = textOf(*target->refusal), .colour = kRefusedColour, .whenHidden = 1});
    }
    if (annotator_) annotator_->appendTo(overlay_);
    if (isDesk(source)) return;
    for (const input::Hand& hand : hands_)
        if (hand.isTracked) addController(overlay_, worldFromWalk_ * locomotion_.rig.toWalk(hand.trackingFromAim), 0);
}

void Walk::advance(WalkStage& stage, const xr::ViewSource& source, const xr::Frame& frame) {
    if (deskSide_ != nullptr) knobs_ = deskSide_->desk.knobs();
    shownUnseen_ = findShownUnseen(stage);
    if (frame.isTracked != wasTracked_)
        say(frame.isTracked ? "the head is tracked again" : "the head is not tracked; its last place is kept");
    wasTracked_ = frame.isTracked;
    if (frame.wasRecentred) say("the headset was recentred");
    tellTime(source, frame);
    go(stage, source, frame);
    const input::Rig& rig = locomotion_.rig;
    const scene::Pose walkFromHead = rig.toWalk(frame.trackingFromHead);
    if (frame.isTracked) {
        facts_.place = walkFromHead.translation;
        heading_ = input::headingOf(walkFromHead.rotation);
    }
    // Where this frame's steps have led, too.
    if (std::exchange(startsHere_, false)) startHere();
    record_.addPose(seconds_, walkFromHead, rig);
}

void Walk::draw(WalkStage& stage, xr::ViewSource& source, const xr::Frame& frame) {
    const input::Rig& rig = locomotion_.rig;
    render::Renderer& renderer = stage.rendererFor(source);
    const auto eyes = static_cast<std::size_t>(source.eyes());
    std::array<scene::View, xr::kEyes> views;
    std::array<render::EyeOutput, xr::kEyes> outputs;
    for (std::size_t eye = 0; eye < eyes; ++eye) {
        views[eye] = {frame.eyes[eye].camera, worldFromWalk_ * rig.toWalk(frame.eyes[eye].worldFromEye)};
        outputs[eye].image = frame.images[eye].image;
        outputs[eye].layer = frame.images[eye].layer;
        outputs[eye].depth = frame.images[eye].depth;
        outputs[eye].depthLayer = frame.images[eye].depthLayer;
        // In metres of the wearer's room, whatever the scale of the world.
        outputs[eye].nearMetres = static_cast<float>(xr::kDepthNearMetres * rig.scale);
    }
    if (isDesk(source) || (deskSide_ != nullptr && deskSide_->desk.wantsPicture())) renderer.keepNext();
    // What is kept as a file is of one size, and any picture at the desk may be.
    renderer.letDisplayEnlarge(!isDesk(source) && !knobs_.isFilmed && !record_.wantsPicture(static_cast<int>(frame_)));
    renderer.letFramesStand(isDesk(source)); // in a headset no head is as still as that
    drawn_ = without(governed_ ? governed_->next(knobs_.quality, renderer.frames()) : knobs_.quality, givenUp_);
    stage.gpuScene().showOnly(selection_.choose(std::span(views).first(eyes), drawn_, seconds_));
    fillOverlay(source);
    if (options_.isHeadless && stage.gpuScene().isStreamed()) {
        if (renderer.frames() > 0) renderer.finish(); // nobody waits, and pictures must not hang on the disk
        stage.gpuScene().settle(std::span(views).first(eyes), drawn_, stage.hidingCoverage());
    } else {
        stage.gpuScene().follow(std::span(views).first(eyes), drawn_, stage.hidingCoverage());
    }
    for (const std::string& sentence : damage_.news(stage.gpuScene(), scene_))
        say(sentence);
    if (governed_ && stage.wasCold()) warmUp(renderer, std::span(views).first(eyes));
    stats_ = renderer.draw(std::span(views).first(eyes), drawn_, std::span(outputs).first(eyes), &overlay_);
    if (deskSide_ != nullptr) mirror(renderer, isDesk(source), frame);

    if (!record_.wantsPicture(static_cast<int>(frame_))) return;
    std::vector<render::EyeImage> pictures = renderer.readBack();
    for (std::size_t eye = 0; eye < eyes; ++eye) {
        // Where there is a headset, what it was given counts and not what we have.
        if (outputs[eye].image != VK_NULL_HANDLE)
            pictures[eye].colour = render::readOutput(stage.device(), outputs[eye], source.width(), source.height());
        record_.addPicture(static_cast<int>(frame_), eye, views[eye], pictures[eye]);
    }
}

/// Before the first frame, so that no rung that the governor takes later holds one up. What there is no memory for is
/// found out when it is asked for.
void Walk::warmUp(render::Renderer& renderer, std::span<const scene::View> eyes) {
    std::vector<render::Quality> ways = governed_->ways();
    for (render::Quality& way : ways)
        way = without(way, givenUp_);
    try {
        renderer.warmUp(eyes, ways);
    } catch (const render::OutOfMemory&) {
    }
    wasWarmedUp_ = true;
    frameBegan_ = std::chrono::steady_clock::now();
}

void Walk::mirror(render::Renderer& renderer, bool isAtDesk, const xr::Frame& frame) {
    // At the desk the picture is for the window and is waited for; in a headset the newest that is finished will do.
    if (isAtDesk) stats_ = renderer.finish();
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - frameAt_).count();
    frameAt_ = now;
    if (seconds < 1) facts_.framesPerSecond += 0.1 * (1 / std::max(seconds, 1e-6) - facts_.framesPerSecond);
    facts_.isAtDesk = isAtDesk;
    facts_.isTracked = frame.isTracked;
    facts_.stats = stats_;
    facts_.given = governed_ ? governed_->given() : "";
    facts_.speed = input::speedOf(locomotion_, knobs_.settings.locomotion);
    facts_.scale = locomotion_.rig.scale;
    deskSide_->desk.tell(facts_);
    if (!renderer.takeKept(mirrored_)) return;
    deskSide_->desk.show(mirrored_);
    xr::Window::wake();
}

json Walk::reportOf(const WalkStage& stage) const {
    json settings{{"scene", options_.scene.string()},     {"display", stage.name()},
                  {"width", stage.source().width()},      {"height", stage.source().height()},
                  {"hidden_share", stage.hiddenShares()}, {"eyes", xr::kEyes}};
    settings.update(toJson(knobs_.quality));
    settings["coverage"] = toJson(stage.coverage());
    settings["damaged_images"] = scene_.damaged.size();
    if (governed_) settings["governor"] = governed_->report();
    if (refreshesMissed_) settings["display_refreshes_missed"] = *refreshesMissed_;
    return report_.summarise(stage.device(), stage.gpuScene(), std::move(settings));
}

} // namespace app
