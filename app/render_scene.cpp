#include "app/render_scene.h"

#include "app/coverage_on_device.h"
#include "app/damage_teller.h"
#include "app/device_trouble.h"
#include "app/drawn_scene.h"
#include "app/frame_pictures.h"
#include "app/frame_report.h"
#include "app/output_file.h"
#include "app/overlays.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/selection.h"
#include "app/stage_store.h"
#include "app/view_files.h"

#include "render/renderer.h"
#include "scene/errors.h"
#include "scene/scene_file.h"
#include "scene/view.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace app {

namespace {

constexpr int kDefaultWidth = 640, kDefaultHeight = 480;
constexpr double kDefaultFieldOfViewRadians =
    1.2; ///< across, for paths: about what a headset's eye sees of a 4:3 picture

scene::Camera pathCamera(const RenderOptions& o) {
    const int width = o.width > 0 ? o.width : kDefaultWidth, height = o.height > 0 ? o.height : kDefaultHeight;
    const double focal = width / (2 * std::tan(kDefaultFieldOfViewRadians / 2));
    return {width, height, focal, focal, width / 2.0, height / 2.0};
}

std::vector<NamedView> listViews(const RenderOptions& o, const scene::Scene& scene) {
    if (!o.path.empty()) return readPathFile(o.path, scene.walkFromWorld, pathCamera(o));
    std::vector<NamedView> views = o.cameras.empty() ? heldOutViews(scene) : readCamerasFile(o.cameras);
    if (views.empty())
        throw scene::Failure("has no held-out cameras to draw", o.scene, "give --path FILE or --cameras FILE");
    for (NamedView& view : views)
        if (o.width > 0) view.camera = scene::resized(view.camera, o.width, o.height);
    return views;
}

/// The scene on a device, and a renderer of the pictures' size; made anew as a whole.
class Canvas {
  public:
    explicit Canvas(const DrawnScene& drawn) : drawn_(drawn) { make(); }

    void makeAnew() {
        renderer_.reset();
        on_ = {};
        device_.reset();
        make();
    }

    render::Renderer& rendererFor(const scene::Camera& camera, int eyes) {
        if (renderer_ && renderer_->width() == camera.width && renderer_->height() == camera.height) return *renderer_;
        renderer_.reset();
        const auto makeIt = [&] {
            renderer_.emplace(*device_, *on_.images, camera.width, camera.height, eyes, on_.coverage.get(),
                              on_.polygons.get());
        };
        makeBeside(*device_, drawn_.scene, on_.coverage, makeIt);
        return *renderer_;
    }

    /// Where there is no memory to draw (giveUpFinest). False if there is no coverage.
    bool giveUpFinestCoverage(const render::OutOfMemory& failure) {
        if (on_.coverage == nullptr) return false;
        renderer_.reset(); // it shows it
        return giveUpFinest(*device_, drawn_.scene, on_.coverage, failure);
    }

    const render::Device& device() const { return *device_; }
    render::GpuScene& gpuScene() { return *on_.images; }
    const render::GpuCoverage* coverage() const { return on_.coverage.get(); }
    const scene::Coverage* hidingCoverage() const { return on_.hidingCoverage(); }

  private:
    void make() {
        device_ = std::make_unique<render::Device>();
        sayPassedOver(*device_);
        on_ = bringTo(*device_, drawn_);
    }

    const DrawnScene& drawn_;
    std::unique_ptr<render::Device> device_;
    DeviceScene on_;
    std::optional<render::Renderer> renderer_;
};

/// Draws and is drawn to the end: pictures of the eyes, and what they took.
std::vector<render::EyeImage> drawOnce(render::Renderer& renderer, std::span<const scene::View> eyeViews,
                                       const render::Quality& quality, const render::Overlay& overlay,
                                       FrameReport& report) {
    renderer.forgetWays();
    const auto start = std::chrono::steady_clock::now();
    renderer.draw(eyeViews, quality, {}, &overlay);
    const render::FrameStats stats = renderer.finish();
    const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
    std::vector<render::EyeImage> images = renderer.readBack();
    report.add(stats, passed.count());
    return images;
}

std::string nameOfEye(const std::string& view, int eyes, std::size_t eye) {
    return view + (eyes == 1 ? "" : eye == 0 ? "-left" : "-right");
}

std::size_t picturesBeside(const std::filesystem::path& folder, const std::set<std::string>& names) {
    return static_cast<std::size_t>(
        std::ranges::count_if(picturesIn(folder), [&](const std::string& name) { return !names.contains(name); }));
}

/// Whether a scene was built from what stands right there, as far as its inputs' names still say.
bool isFolderOfInput(const std::filesystem::path& folder, const std::filesystem::path& input) {
    std::error_code ignored;
    const auto isIt = [&](const std::filesystem::path& other) {
        return std::filesystem::equivalent(folder, other, ignored);
    };
    if (!std::filesystem::is_directory(input, ignored)) return isIt(std::filesystem::absolute(input).parent_path());
    return isIt(input) || std::ranges::any_of(std::array{"images", "image", "rgb", "color"},
                                              [&](const char* name) { return isIt(input / name); });
}

/// Pictures are drawn under the names of those that were kept out, and must not be put in their place: not where they
/// stand among others, or where the scene's inputs do, and no report says that a run like this wrote them. (One that
/// was stopped leaves its own alone.)
void checkReplacesNothing(const std::filesystem::path& folder, const scene::Scene& scene,
                          const std::vector<NamedView>& views, int eyes) {
    checkReplaceableReport(folder, isDrawnReport);
    if (!reportIn(folder, isDrawnReport).is_null()) return;
    std::error_code ignored;
    std::set<std::string> names;
    std::string replaced;
    for (const NamedView& view : views)
        for (std::size_t eye = 0; eye < static_cast<std::size_t>(eyes); ++eye)
            for (const char* end : {".png", "-depth.tiff", "-class.png"}) {
                const std::string name = nameOfEye(view.name, eyes, eye) + end;
                if (std::filesystem::exists(folder / name, ignored) && replaced.empty()) replaced = name;
                names.insert(name);
            }
    if (replaced.empty()) return;
    const nlohmann::json inputs = nlohmann::json::parse(scene.manifest).at("provenance").at("inputs");
    const bool isOfInput = std::ranges::any_of(
        inputs, [&](const nlohmann::json& input) { return isFolderOfInput(folder, input.get<std::string>()); });
    if (isOfInput || picturesBeside(folder, names) > 0)
        throw scene::Failure("holds pictures that no finished 'revisit render' speaks of, and " + replaced +
                                 " would be replaced",
                             folder, "name another folder with --out");
}

/// Pictures there that this run did not write: none of them is what the report speaks of.
void sayWhatIsOlder(const std::filesystem::path& folder, const std::set<std::string>& names) {
    if (const std::size_t older = picturesBeside(folder, names); older > 0)
        sayNote("'" + folder.string() + "' holds pictures that this run did not draw, " + std::to_string(older) +
                " of them: report.json does not speak of those.");
}

} // namespace

void renderScene(const RenderOptions& options) {
    const scene::Scene scene = scene::openScene(options.scene, scene::DamagedHeads::leftOut);
    for (const std::string& sentence : DamageTeller::lost(scene))
        say(sentence);
    const std::vector<NamedView> views = listViews(options, scene);
    const int eyes = options.eyes > 0 ? options.eyes : options.path.empty() ? 1 : 2;
    checkReplacesNothing(options.out, scene, views, eyes);
    const render::Quality quality = qualityOf(options.draw);
    DrawnScene drawnScene(scene, options.draw);
    drawnScene.mayShowUnseen = quality.showUnseen;
    Canvas canvas(drawnScene);
    sayWhatCannotBeHad(canvas.device(), quality, eyes);
    DamageTeller damage;
    Selection selection(scene);
    if (options.showsCells && !selection.hasCells())
        throw scene::Failure("has no walk cells to show", options.scene,
                             "build it with --no-cull from scans or polygons at several positions");
    const scene::Pose worldFromWalk = inverse(scene.walkFromWorld);

    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error)
        throw scene::Failure("cannot be made (" + error.message() + ")", options.out,
                             "check that the folder may be written");

    FrameReport report;
    LossWatch losses;
    GivenUp givenUp;
    scene::Camera drawn;
    std::set<std::string> written;
    Progress progress("render", views.size());
    for (const NamedView& view : views) {
        drawn = view.camera;
        std::vector<scene::View> eyeViews{{view.camera, view.worldFromCamera}};
        if (eyes == 2) {
            const auto [left, right] = scene::eyesOf(view.camera, view.worldFromCamera, options.draw.eyeDistanceMetres);
            eyeViews = {left, right};
        }
        std::vector<render::EyeImage> images;
        while (images.empty()) {
            const render::Quality given = without(quality, givenUp);
            try {
                canvas.gpuScene().showOnly(selection.choose(eyeViews, given));
                canvas.gpuScene().settle(eyeViews, given, canvas.hidingCoverage());
                for (const std::string& sentence : damage.news(canvas.gpuScene(), scene))
                    say(sentence);
                render::Overlay overlay;
                if (options.showsCells) addCells(overlay, worldFromWalk, selection, view.worldFromCamera.translation);
                images = drawOnce(canvas.rendererFor(view.camera, eyes), eyeViews, given, overlay, report);
            } catch (const render::OutOfMemory& failure) {
                if (!giveUpMore(given, failure, givenUp) && !canvas.giveUpFinestCoverage(failure)) throw;
            } catch (const render::DeviceLost& loss) {
                losses.tell(loss);
                canvas.makeAnew();
            }
        }
        for (std::size_t eye = 0; eye < images.size(); ++eye)
            for (std::string& name :
                 writePictures(images[eye], options.out, nameOfEye(view.name, eyes, eye), options.aux))
                written.insert(std::move(name));
        progress.advance();
    }
    nlohmann::json settings{{"scene", options.scene.string()},
                            {"width", drawn.width},
                            {"height", drawn.height},
                            {"eyes", eyes},
                            {"ipd_m", options.draw.eyeDistanceMetres}};
    settings.update(toJson(without(quality, givenUp)));
    settings["shows_unseen"] = canvas.coverage() != nullptr;
    settings["coverage"] = toJson(canvas.coverage());
    settings["damaged_chunks"] = damage.chunks();
    settings["damaged_images"] = scene.damaged.size();
    writeWhole(options.out / "report.json",
               report.summarise(canvas.device(), canvas.gpuScene(), settings)
                       .dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + // paths need not be UTF-8
                   "\n");
    if (const auto remark = report.remark(); remark && options.draw.polygons.empty() && scene.damaged.empty())
        sayNote(*remark);
    sayWhatIsOlder(options.out, written);
}

} // namespace app
