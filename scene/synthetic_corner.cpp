// The street corner of scene/synthetic.h: two streets along x and y cross at the origin; houses on three
// corners and a small park on the fourth; two cars that have just met in the middle.

#include "scene/synthetic.h"

#include "scene/synthetic_furniture.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr double kHalfRoad = 3.5, kPavement = 2.6, kKerb = 0.13, kNear = 8.0, kFar = 34.0; // metres

class StreetCorner {
  public:
    explicit StreetCorner(std::uint32_t seed) : seed_(seed), random_(seed) {
        model_.name = "corner";
        model_.lightSpacing = 0.30;
        model_.exposure = 0.95;
        model_.sky.towardsSun = glm::normalize(glm::dvec3(0.52, -0.62, 0.66));
        model_.sky.sun = glm::dvec3(1.75, 1.6, 1.35);
        model_.sky.zenith = glm::dvec3(0.16, 0.36, 0.85);
        model_.sky.horizon = glm::dvec3(0.72, 0.86, 1.05);
        model_.sky.seed = seed + 5;
    }

    SyntheticModel build() {
        addGround();
        addHouses();
        addStreetThings();
        addPark();
        addCollision();
        model_.walk = {{{-5.4, -4.6, 1.6}, {0.6, 0.2, 0.7}}, {{-1.2, -5.2, 1.6}, {0.8, 0.3, 0.7}},
                       {{3.6, -4.2, 1.6}, {0.6, 0.6, 0.8}},  {{5.3, -0.6, 1.6}, {0.2, 0.4, 0.8}},
                       {{4.7, 3.8, 1.6}, {0.2, 0.2, 0.8}},   {{0.9, 5.3, 1.6}, {0.4, 0.0, 0.8}},
                       {{-3.8, 4.4, 1.6}, {0.4, 0.0, 0.8}},  {{-5.6, 0.2, 1.6}, {0.6, 0.4, 0.8}}};
        model_.tripods = {{-5.0, -4.8, 1.6}, {4.6, -4.4, 1.6}, {4.9, 4.4, 1.6}, {-4.4, 4.7, 1.6}};
        return std::move(model_);
    }

  private:
    void addGround() {
        const int road = addMaterial(model_, {Pattern::road, reflectance(0x4d4d50), reflectance(0x77777a), 1.0, 91});
        addRoad(kFar, {{glm::dvec2(-kNear), glm::dvec2(kNear)}}, road).lightSpacing = 1.2;
        addRoad(kNear, {}, road);

        const int slabs = addMaterial(model_, {Pattern::slabs, reflectance(0xa9a49a), reflectance(0x6d6961), 0.60, 92});
        const int stone = addMaterial(model_, {Pattern::slabs, reflectance(0xbdb9b0), reflectance(0x7d7a73), 1.0, 93});
        for (const double sx : {-1.0, 1.0})
            for (const double sy : {-1.0, 1.0}) {
                const auto box = [&](double x0, double y0, double x1, double y1, double top, int material) {
                    addBox(model_, Pose{}, {std::min(sx * x0, sx * x1), std::min(sy * y0, sy * y1), 0},
                           {std::max(sx * x0, sx * x1), std::max(sy * y0, sy * y1), top}, material);
                };
                const double edge = kHalfRoad + 0.15, back = kHalfRoad + kPavement;
                box(kHalfRoad, kHalfRoad, edge, kFar, kKerb, stone);
                box(edge, kHalfRoad, kFar, edge, kKerb, stone);
                box(edge, edge, back, kFar, kKerb - 0.004, slabs);
                box(back, edge, kFar, back, kKerb - 0.004, slabs);
            }
    }

    /// A square about the origin. Its markings are given in world coordinates, and so is the place of its
    /// hole.
    Patch& addRoad(double half, std::vector<Rectangle> holes, int material) {
        Patch& ground =
            addRectangle(model_, {-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0}, material, std::move(holes));
        ground.origin = glm::dvec3(0);
        for (glm::dvec2& corner : ground.outline)
            corner -= half;
        ground.extent = {glm::dvec2(-half), glm::dvec2(half)};
        return ground;
    }

    struct House {
        double x0, y0, x1, y1;
        int floors;
        std::uint32_t wall;
        Pattern pattern;
    };

    void addHouses() {
        const double near = kHalfRoad + kPavement;
        const std::size_t first = model_.patches.size();
        addHouse({-near - 11.0, near, -near, near + 12.0, 3, 0x9c5a43, Pattern::bricks});
        addHouse({-near - 25.0, near, -near - 11.05, near + 9.0, 2, 0xd9cba8, Pattern::plaster});
        addHouse({-near - 9.0, near + 12.05, -near, near + 27.0, 4, 0xbcae9a, Pattern::plaster});
        addHouse({near, near, near + 9.0, near + 9.5, 4, 0xcfc3ae, Pattern::plaster});
        addHouse({near + 9.05, near, near + 26.0, near + 8.0, 3, 0x7f4a3a, Pattern::bricks});
        addHouse({near, near + 9.55, near + 8.0, near + 27.0, 2, 0xa8b4b0, Pattern::plaster});
        addHouse({-near - 9.5, -near - 10.0, -near, -near, 3, 0xb4683f, Pattern::bricks});
        addHouse({-near - 26.0, -near - 8.0, -near - 9.55, -near, 4, 0xc9b7a2, Pattern::plaster});
        addHouse({-near - 8.0, -near - 27.0, -near, -near - 10.05, 2, 0xd6d0c2, Pattern::plaster});
        // Across the far ends of the streets and beyond the park.
        addHouse({-8.0, kFar - 1.0, 8.0, kFar + 6.0, 4, 0xa05c48, Pattern::bricks});
        addHouse({-8.0, -kFar - 6.0, 8.0, -kFar + 1.0, 3, 0xd4c4a4, Pattern::plaster});
        addHouse({kFar - 1.0, -8.0, kFar + 6.0, 8.0, 3, 0xc2c6c4, Pattern::plaster});
        addHouse({-kFar - 6.0, -8.0, -kFar + 1.0, 8.0, 4, 0x8f5140, Pattern::bricks});
        addHouse({12.0, -kFar, kFar + 4.0, -24.0, 3, 0xb98a6a, Pattern::bricks});
        addHouse({27.0, -23.95, kFar + 4.0, -8.05, 2, 0xcdbfa5, Pattern::plaster});
        addHouse({near - 1.0, -kFar - 8.0, 14.0, -kFar - 2.0, 3, 0x9c6a50, Pattern::bricks});
        addHouse({kFar - 4.0, 5.0, kFar + 8.0, 20.0, 3, 0xb9a78c, Pattern::plaster});
        addHouse({-kFar - 9.0, -20.0, -kFar + 4.0, -7.0, 2, 0xb4683f, Pattern::bricks});
        addHouse({-kFar - 9.0, 7.0, -kFar + 4.0, 20.0, 3, 0xcfc3ae, Pattern::plaster});
        addHouse({-20.0, -kFar - 9.0, -7.0, -kFar + 2.0, 3, 0xcdbfa5, Pattern::plaster});
        addHouse({-20.0, kFar - 2.0, -7.0, kFar + 9.0, 3, 0xa8b4b0, Pattern::plaster});
        addHouse({7.0, kFar - 2.0, 20.0, kFar + 9.0, 3, 0x9c5a43, Pattern::bricks});
        // Houses are large and far: their light changes slowly.
        for (std::size_t i = first; i < model_.patches.size(); ++i)
            model_.patches[i].lightSpacing = 0.9;
    }

    void addHouse(const House& house) {
        const double storey = 3.1, height = house.floors * storey + 0.5;
        const int wall = addMaterial(model_, {house.pattern, reflectance(house.wall), reflectance(0xa59d90), 0.24,
                                              static_cast<std::uint32_t>(random_.bits() & 511)});
        const int plinth = addMaterial(model_, {Pattern::slabs, reflectance(0x8b867c), reflectance(0x5e5a53), 0.9, 95});
        const int trim = addMaterial(model_, {Pattern::plaster, reflectance(0xe6dfcf)});
        const glm::dvec3 a(house.x0, house.y0, 0), b(house.x1, house.y0, 0), c(house.x1, house.y1, 0),
            d(house.x0, house.y1, 0);
        addFacade(a, b, house, height, wall, trim);
        addFacade(b, c, house, height, wall, trim);
        addFacade(c, d, house, height, wall, trim);
        addFacade(d, a, house, height, wall, trim);
        const Pose world;
        const int roof = addMaterial(model_, {Pattern::mottled, reflectance(0x5b4a44), reflectance(0x7a655c), 0.6, 96});
        addBox(model_, world, {house.x0 - 0.32, house.y0 - 0.32, height - 0.28},
               {house.x1 + 0.32, house.y1 + 0.32, height - 0.06}, trim);
        addBox(model_, world, {house.x0 - 0.16, house.y0 - 0.16, height - 0.06},
               {house.x1 + 0.16, house.y1 + 0.16, height + 0.30}, roof);
        addBox(model_, world, {house.x0 - 0.05, house.y0 - 0.05, 0}, {house.x1 + 0.05, house.y1 + 0.05, 0.62}, plinth);
        addBox(model_, world, {house.x0 - 0.04, house.y0 - 0.04, storey + 0.28},
               {house.x1 + 0.04, house.y1 + 0.04, storey + 0.46}, trim);
        const int brick =
            addMaterial(model_, {Pattern::bricks, reflectance(0x8a4a38), reflectance(0xa59d90), 0.24, 97});
        addBox(model_, world, {house.x0 + 2.0, (house.y0 + house.y1) / 2 - 0.4, height},
               {house.x0 + 3.0, (house.y0 + house.y1) / 2 + 0.4, height + 1.5}, brick);
    }

    /// A wall from one corner to another, seen from outside with the first on the left: rows of set-back
    /// windows.
    void addFacade(const glm::dvec3& from, const glm::dvec3& to, const House& house, double height, int wall,
                   int trim) {
        const double width = glm::length(to - from);
        const glm::dvec3 along = (to - from) / width, up(0, 0, 1), out = glm::cross(along, up);
        const Pose face{glm::dmat3(along, -out, up), from}; // x along, y inwards, z up
        const int columns = std::max(1, static_cast<int>((width - 1.0) / 2.6));
        const double pitch = width / columns, storey = 3.1;
        std::vector<Rectangle> holes;
        const glm::dvec3 middleOfWall = (from + to) / 2.0;
        const bool isSeen = glm::dot(out, middleOfWall) < 0; // windows only where the crossing looks
        for (int floor = 0; isSeen && floor < house.floors; ++floor)
            for (int column = 0; column < columns; ++column) {
                const double middle = pitch * (column + 0.5), half = floor == 0 ? 0.62 : 0.55;
                const double low = floor * storey + (floor == 0 ? 0.95 : 0.98), high = floor * storey + 2.55;
                holes.push_back({{middle - half, low}, {middle + half, high}});
            }
        addRectangle(model_, from, along * width, up * height, wall, holes);
        const double deep = 0.20;
        for (const Rectangle& hole : holes) {
            const double w = hole.high.x - hole.low.x, h = hole.high.y - hole.low.y;
            const auto at = [&](double x, double y, double z) { return face * glm::dvec3(x, y, z); };
            addRectangle(model_, at(hole.low.x, 0, hole.low.y), along * w, -out * deep, trim);
            addRectangle(model_, at(hole.low.x, 0, hole.high.y), -out * deep, along * w, trim);
            addRectangle(model_, at(hole.low.x, 0, hole.low.y), -out * deep, up * h, trim);
            addRectangle(model_, at(hole.high.x, deep, hole.low.y), out * deep, up * h, trim);
            const int pane = addMaterial(model_, {Pattern::pane, glm::dvec3(0.035, 0.042, 0.05), reflectance(0xe8e4da),
                                                  w / 2, static_cast<std::uint32_t>(random_.bits() & 255)});
            if (random_.unit() < 0.06)
                addOpenWindow(face, hole, deep, pane);
            else
                addRectangle(model_, at(hole.low.x, deep, hole.low.y), along * w, up * h, pane);
            addBox(model_, face, {hole.low.x - 0.08, -0.09, hole.low.y - 0.08},
                   {hole.high.x + 0.08, 0.03, hole.low.y - 0.001}, trim);
            addBox(model_, face, {hole.low.x - 0.06, -0.035, hole.high.y + 0.001},
                   {hole.high.x + 0.06, 0.02, hole.high.y + 0.16}, trim);
        }
    }

    /// An opening one can look into: a bare room behind it.
    void addOpenWindow(const Pose& face, const Rectangle& hole, double front, int pane) {
        const int plain = addMaterial(model_, {Pattern::plaster, reflectance(0xb7a98f)});
        const double x0 = hole.low.x, x1 = hole.high.x, z0 = hole.low.y, z1 = hole.high.y, back = front + 1.2;
        const auto at = [&](double x, double y, double z) { return face * glm::dvec3(x, y, z); };
        const glm::dvec3 along = face.rotation[0], in = face.rotation[1], up = face.rotation[2];
        addRectangle(model_, at(x0, back, z0), along * (x1 - x0), up * (z1 - z0), plain);
        addRectangle(model_, at(x0, front, z0), along * (x1 - x0), in * 1.2, plain);
        addRectangle(model_, at(x0, front, z1), in * 1.2, along * (x1 - x0), plain);
        addRectangle(model_, at(x0, front, z0), in * 1.2, up * (z1 - z0), plain);
        addRectangle(model_, at(x1, back, z0), -in * 1.2, up * (z1 - z0), plain);
        const Pose sash = face * standing({x0, 0.02, 0}, -1.25);
        addBox(model_, sash, {0, 0, z0 + 0.01}, {(x1 - x0) / 2, 0.035, z1 - 0.01}, pane);
    }

    void addStreetThings() {
        const int iron = addMaterial(model_, {Pattern::mottled, reflectance(0x2d3436), reflectance(0x454e50), 0.1, 98});
        const int grey = addMaterial(model_, {Pattern::mottled, reflectance(0x8d9193), reflectance(0xa7abad), 0.1, 99});
        const int lamp = addMaterial(model_, {Pattern::plain, reflectance(0xf4eedc)});
        for (const glm::dvec2 at : {glm::dvec2(-4.15, 8.5), glm::dvec2(8.5, 4.15), glm::dvec2(4.15, -9.0),
                                    glm::dvec2(-10.0, -4.15), glm::dvec2(-4.15, 22.0), glm::dvec2(22.0, 4.15)}) {
            addRod(model_, {at.x, at.y, kKerb - 0.01}, {at.x, at.y, 0.9}, 0.085, iron);
            addTube(model_, {at.x, at.y, 0.9}, {at.x, at.y, 4.6}, 0.05, iron);
            addRod(model_, {at.x, at.y, 4.6}, {at.x, at.y, 4.68}, 0.16, iron);
            addSphere(model_, {at.x, at.y, 4.86}, 0.19, lamp);
        }
        const int redSign =
            addMaterial(model_, {Pattern::stripes, reflectance(0xb5201d), reflectance(0xeeeae2), 0.30, 0});
        const int blue = addMaterial(model_, {Pattern::stripes, reflectance(0x1f4f9a), reflectance(0xe8ecf2), 0.22, 0});
        addSign({-4.25, -7.9, 0}, {-0.6, -0.8, 0}, redSign, grey);
        addSign({4.3, 7.2, 0}, {0.8, 0.6, 0}, blue, grey);
        addSign({4.3, -7.6, 0}, {0, -1, 0}, blue, grey);
        for (int i = 0; i < 5; ++i)
            addRod(model_, {-4.0, 5.2 + 1.1 * i, kKerb - 0.01}, {-4.0, 5.2 + 1.1 * i, 1.02}, 0.055, iron);
        for (int i = 0; i < 5; ++i)
            addRod(model_, {5.2 + 1.1 * i, 4.0, kKerb - 0.01}, {5.2 + 1.1 * i, 4.0, 1.02}, 0.055, iron);
        const int bin = addMaterial(model_, {Pattern::mottled, reflectance(0x2f5b3c), reflectance(0x447a53), 0.1, 100});
        addRod(model_, {-5.5, 5.7, kKerb - 0.01}, {-5.5, 5.7, 0.98}, 0.24, bin);
        addBox(model_, standing({5.6, 5.45, kKerb - 0.01}, 0.0), {-0.35, -0.25, 0}, {0.35, 0.25, 1.25},
               addMaterial(model_, {Pattern::plaster, reflectance(0xc9a227)}));
        const int cable = addMaterial(model_, {Pattern::plain, glm::dvec3(0.02)});
        for (int i = 0; i < 12; ++i) { // a cable from lamp to lamp, across the street
            const auto hang = [](double t) {
                return glm::dvec3(-4.15 + 8.3 * t, 8.5, 4.6 + 2.2 * (t - 0.5) * (t - 0.5) - 0.55);
            };
            addTube(model_, hang(i / 12.0), hang((i + 1) / 12.0), 0.012, cable);
        }
        addRod(model_, {4.15, 8.5, kKerb - 0.01}, {4.15, 8.5, 4.7}, 0.05, iron);
    }

    void addSign(const glm::dvec3& at, const glm::dvec3& facing, int face, int metal) {
        addTube(model_, at + glm::dvec3(0, 0, kKerb - 0.01), at + glm::dvec3(0, 0, 2.75), 0.03, metal);
        const glm::dvec3 out = glm::normalize(facing), centre = at + glm::dvec3(0, 0, 2.45);
        addTube(model_, centre + out * 0.031, centre + out * 0.045, 0.30, metal);
        addDisc(model_, centre + out * 0.031, -out, 0.30, metal);
        addDisc(model_, centre + out * 0.045, out, 0.30, face);
    }

    void addPark() {
        const double near = kHalfRoad + kPavement;
        const int grass =
            addMaterial(model_, {Pattern::mottled, reflectance(0x3f6a2a), reflectance(0x86a04e), 0.35, 101});
        addRectangle(model_, {near, -kFar, kKerb + 0.02}, {kFar - near, 0, 0}, {0, kFar - near, 0}, grass);
        addHedge(model_, standing({near + 4.6, -near - 0.5, kKerb}, 0), {7.6, 0.7, 1.0}, 1500, random_);
        addHedge(model_, standing({near + 0.5, -near - 5.2, kKerb}, 1.5707963267948966), {7.0, 0.7, 1.0}, 1400,
                 random_);
        addTree(model_, {near + 2.6, -near - 2.6, kKerb}, 6.2, 1500, random_);
        addTree(model_, {near + 9.5, -near - 4.0, kKerb}, 7.4, 1500, random_);
        addTree(model_, {near + 4.4, -near - 11.0, kKerb}, 7.8, 1500, random_);
        addTree(model_, {near + 16.0, -near - 9.0, kKerb}, 8.2, 1100, random_);
        addTree(model_, {-5.3, -14.0, kKerb}, 5.6, 1000, random_);
    }

    void addCollision() {
        CarShape struck, striking;
        striking.paint = reflectance(0xa81e1e);
        striking.frontCrush = 0.46, striking.seed = seed_ * 2 + 11;
        struck.paint = reflectance(0x3c6ea0);
        struck.sideDent = 0.34, struck.dentAt = 0.46, struck.seed = seed_ * 2 + 12;
        addCar(model_, standing({0.35, 1.10, 0}, -0.24), struck);
        addCar(model_, standing({1.02, -1.25, 0}, 1.78), striking);
        CarShape parked;
        parked.paint = reflectance(0xd9dadb), parked.seed = 31, parked.fineness = 0.5;
        addCar(model_, standing({-2.35, 14.5, 0}, 1.5707963267948966), parked);
        parked.paint = reflectance(0x2f4a3c), parked.seed = 32;
        addCar(model_, standing({13.5, 2.4, 0}, 3.141592653589793), parked);
        parked.paint = reflectance(0x8a8f96), parked.seed = 33;
        addCar(model_, standing({-14.0, -2.4, 0}, 0.0), parked);
        addDebris();
    }

    /// Shards, splinters and a torn bumper around the place of the impact.
    void addDebris() {
        const int shard = addMaterial(model_, {Pattern::plain, glm::dvec3(0.30, 0.36, 0.36)});
        const int black = addMaterial(model_, {Pattern::plain, glm::dvec3(0.02)});
        const int red = addMaterial(model_, {Pattern::plain, reflectance(0xa81e1e)});
        for (int i = 0; i < 120; ++i) {
            const double angle = random_.between(0, 6.283), reach = 0.5 + 2.6 * std::sqrt(random_.unit());
            const glm::dvec3 at(0.6 + reach * std::cos(angle), -0.2 + reach * std::sin(angle), 0.0);
            const double size = random_.between(0.008, 0.04);
            addBox(model_, standing(at, random_.between(0, 6.283)), {-size, -size * 0.6, 0.0005},
                   {size, size * 0.6, 0.004 + size * random_.between(0.1, 0.5)},
                   i % 5 == 0   ? red
                   : i % 3 == 0 ? black
                                : shard);
        }
        const auto arc = [](double s) {
            return glm::dvec3(-0.75 + 1.0 * s, -0.85 - 0.45 * s * (1 - s), 0.06 + 0.12 * s * (1 - s));
        };
        for (int i = 0; i < 8; ++i)
            addRod(model_, arc(i / 8.0), arc((i + 1) / 8.0), 0.045, black);
        const int rubber = addMaterial(model_, {Pattern::mottled, glm::dvec3(0.028), glm::dvec3(0.075), 0.10, 102});
        for (const double side : {-0.76, 0.76}) { // skid marks of the car that came from below
            const Pose track = standing({1.30, -2.58, 0}, 0.209);
            addRectangle(model_, track * glm::dvec3(side - 0.09, -5.2, 0.0015), track.rotation * glm::dvec3(0.18, 0, 0),
                         track.rotation * glm::dvec3(0, 5.2, 0), rubber);
        }
    }

    SyntheticModel model_;
    std::uint32_t seed_ = 1;
    SeededSequence random_;
};

} // namespace

SyntheticScene makeStreetCorner(std::uint32_t seed) {
    return SyntheticScene(StreetCorner(seed).build());
}

} // namespace scene
