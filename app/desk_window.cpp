#include "app/desk_window.h"

#include "app/panel.h"
#include "app/picture_keeper.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace app {

namespace {

/// How often events are looked for where nothing wakes the window; and how often the panel is drawn at most.
constexpr double kTick = 1.0 / 60;

class DeskWindow {
  public:
    DeskWindow(xr::Window& window, Desk& desk, xr::Desktop& desktop)
        : window_(window), desk_(desk), desktop_(desktop), keyboard_(window.handle()), knobs_(desk.knobs()) {}

    DeskEnd run() {
        while (window_.isOpen() && !desk_.isOver()) {
            window_.takeEvents(kTick);
            listen();
            resize();
            if (desk_.take(pictures_)) {
                showPictures();
                desk_.askForPicture();
                desktop_.ask();
            }
            window_.draw([&] { drawPanel(desk_.facts(), state_, knobs_); });
            knobs_.deskEyes = state_.view == PanelState::View::both ? 2 : 1;
            desk_.turn(knobs_);
        }
        keeper_.endFilm();
        desktop_.close();
        if (desk_.isOver()) return DeskEnd::walkOver;
        return hasLeft_ ? DeskEnd::left : DeskEnd::windowClosed;
    }

  private:
    void listen() {
        // The panel itself learns only with its next frame where the mouse has gone.
        const bool isOnPanel = window_.panelHasMouse() || window_.hasMouseIn(state_.area);
        input::DeskSays says = keyboard_.read(!window_.panelHasKeys(), !isOnPanel);
        obey(says);
        desktop_.tilt(says.tilt);
        // In shares of the picture it points at: the walk does not know of windows.
        isPointing_ = false;
        for (std::size_t i = 0; i < 2 && !isPointing_; ++i) {
            const xr::WindowArea area = window_.areaOf(i);
            if (area.width <= 0) continue;
            const glm::dvec2 share{(says.cursor.x - area.x) / area.width, (says.cursor.y - area.y) / area.height};
            isPointing_ = share.x >= 0 && share.x < 1 && share.y >= 0 && share.y < 1;
            if (isPointing_) says.cursor = share;
        }
        if (std::exchange(state_.startsHere, false))
            says.commands.set(static_cast<std::size_t>(input::Command::startHere));
        if (!isPointing_) says.picks = says.teleports = false;
        desk_.say(says);
    }

    void obey(const input::DeskSays& says) {
        using input::Command;
        if (says.said(Command::panel)) state_.isOpen = !state_.isOpen;
        if (says.said(Command::fullScreen)) window_.toggleFullScreen();
        if (says.said(Command::screenshot)) keeper_.keep(shownPictures(), shownPlace());
        if (says.said(Command::video)) {
            state_.isFilming = !state_.isFilming && keeper_.beginFilm();
            if (!state_.isFilming) keeper_.endFilm();
            knobs_.isFilmed = state_.isFilming;
        }
        if (says.said(Command::viewWalker)) state_.view = PanelState::View::walker;
        if (says.said(Command::viewLeft)) state_.view = PanelState::View::left;
        if (says.said(Command::viewBoth)) state_.view = PanelState::View::both;
        if (says.said(Command::warp))
            knobs_.quality.warp =
                knobs_.quality.warp == render::Warp::points ? render::Warp::mesh : render::Warp::points;
        if (says.said(Command::unseen)) knobs_.quality.showUnseen = !knobs_.quality.showUnseen;
        if (says.said(Command::cameras)) knobs_.showsCameras = !knobs_.showsCameras;
        if (says.said(Command::floorGrid)) knobs_.settings.showsFloorGrid = !knobs_.settings.showsFloorGrid;
        if (says.said(Command::quit)) {
            hasLeft_ = true;
            window_.close();
        }
    }

    void resize() {
        const int width = window_.width(), height = window_.height();
        if (width == 0 || height == 0) return;
        const auto scaled = [&](int pixels) {
            return std::max(1, static_cast<int>(std::lround(pixels * knobs_.resolutionScale)));
        };
        desktop_.resize(scaled(width / knobs_.deskEyes), scaled(height), knobs_.deskEyes,
                        knobs_.settings.eyeHeightMetres);
    }

    std::vector<xr::WindowPicture> shownPictures() const {
        std::vector<xr::WindowPicture> shown;
        for (const std::vector<std::uint32_t>& pixels : pictures_.eyes)
            shown.push_back({pixels, pictures_.width, pictures_.height});
        if (shown.size() > 1 && state_.view != PanelState::View::both) shown.resize(1);
        return shown;
    }

    /// The middle of what is shown, world.
    glm::dvec3 shownPlace() const {
        const std::size_t eyes = shownPictures().size();
        glm::dvec3 sum(0);
        for (std::size_t eye = 0; eye < eyes; ++eye)
            sum += pictures_.places[eye];
        return sum / static_cast<double>(std::max<std::size_t>(eyes, 1));
    }

    void showPictures() {
        const std::vector<xr::WindowPicture> shown = shownPictures();
        window_.show(shown);
        if (state_.isFilming) keeper_.addToFilm(shown);
    }

    xr::Window& window_;
    Desk& desk_;
    xr::Desktop& desktop_;
    input::Keyboard keyboard_;
    Knobs knobs_;
    PanelState state_;
    PictureKeeper keeper_;
    render::FramePictures pictures_;
    bool isPointing_ = false, hasLeft_ = false;
};

} // namespace

DeskEnd runDeskWindow(xr::Window& window, Desk& desk, xr::Desktop& desktop) {
    return DeskWindow(window, desk, desktop).run();
}

} // namespace app
