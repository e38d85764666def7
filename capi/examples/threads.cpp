// Many contacts at the same time, each in a thread of its own, and one that all threads share.
//
// A model is an object with its own lock. Here every thread copies a contact, takes it through the same motion, saves and
// restores it on the way, and must find what one contact alone finds, bit by bit.
//
//     c++ -std=c++17 threads.cpp $(pkg-config --cflags --libs stickslip) -lpthread && ./a.out friction.toml
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <stickslip.h>
#include <string>
#include <thread>
#include <vector>

namespace {

void need(stickslip_status status) {
    if (status != STICKSLIP_STATUS_OK) {
        throw std::runtime_error(stickslip_error_text());
    }
}

struct Free {
    void operator()(stickslip_model *model) const { stickslip_free(model); }
    void operator()(stickslip_state *state) const { stickslip_state_free(state); }
};
using Model = std::unique_ptr<stickslip_model, Free>;
using State = std::unique_ptr<stickslip_state, Free>;

Model create(const std::string &text) {
    stickslip_model *model = nullptr;
    need(stickslip_create(text.c_str(), &model));
    return Model(model);
}

Model copy(const Model &from) {
    stickslip_model *model = nullptr;
    need(stickslip_copy(from.get(), &model));
    return Model(model);
}

State save(const Model &model) {
    stickslip_state *state = nullptr;
    need(stickslip_save(model.get(), &state));
    return State(state);
}

// The state as bytes and back, as between two processes.
State through_bytes(const Model &model, const State &state) {
    std::vector<unsigned char> bytes(stickslip_state_size(state.get()));
    need(stickslip_state_write(state.get(), bytes.data(), bytes.size()));
    stickslip_state *read = nullptr;
    need(stickslip_state_read(model.get(), bytes.data(), bytes.size(), &read));
    return State(read);
}

std::size_t find(const Model &model, int kind, const char *name) {
    std::size_t index = 0;
    need(stickslip_variable_find(model.get(), kind, name, &index));
    return index;
}

// Forces over a motion; with `detours` the contact also goes elsewhere and is put back.
std::vector<double> run(const Model &contact, bool detours) {
    std::vector<double> input(stickslip_variable_count(contact.get(), STICKSLIP_KIND_INPUT));
    std::vector<double> output(stickslip_variable_count(contact.get(), STICKSLIP_KIND_OUTPUT));
    const auto displacement = find(contact, STICKSLIP_KIND_INPUT, "displacement");
    const auto force = find(contact, STICKSLIP_KIND_OUTPUT, "force");
    input[find(contact, STICKSLIP_KIND_INPUT, "normal_load")] = 147.15;
    need(stickslip_start(contact.get(), input.data(), 0.0, nullptr));
    std::vector<double> forces;
    for (int step = 1; step <= 2000; ++step) {
        if (detours && step % 100 == 0) {
            const State saved = through_bytes(contact, save(contact));
            input[displacement] = 1e-3;
            need(stickslip_step(contact.get(), input.data(), 1e-3, nullptr));
            need(stickslip_restore(contact.get(), saved.get()));
        }
        input[displacement] = 4e-5 * std::sin(0.05 * step) + 1e-5 * std::sin(0.13 * step);
        need(stickslip_step(contact.get(), input.data(), 1e-3, output.data()));
        forces.push_back(output[force]);
    }
    return forces;
}

std::string refusal(stickslip_status status) {
    return status == STICKSLIP_STATUS_REFUSED ? stickslip_error_text() : "not refused";
}

bool contains(const std::string &text, const char *part) { return text.find(part) != std::string::npos; }

// Whatever is wrong is refused with a text, and changes nothing.
bool refuses(const Model &contact) {
    const double far_off[] = {std::nan(""), 0.0, 1.0};
    stickslip_model *none = nullptr;
    size_t index = 0;
    double number = 0.0;
    const auto kind = STICKSLIP_KIND_INPUT;
    return contains(refusal(stickslip_create("kind =\n", &none)), "line 1") && none == nullptr &&
           contains(refusal(stickslip_create(nullptr, &none)), "NULL") &&
           contains(refusal(stickslip_variable_find(contact.get(), kind, "speed", &index)), "displacement") &&
           contains(refusal(stickslip_step(nullptr, nullptr, 1.0, nullptr)), "model is NULL") &&
           contains(refusal(stickslip_step(contact.get(), nullptr, -1.0, nullptr)), "-1") &&
           contains(refusal(stickslip_step(contact.get(), far_off, 1.0, nullptr)), "displacement") &&
           contains(refusal(stickslip_set_parameter(contact.get(), 0, -1.0)), "above 0") &&
           contains(refusal(stickslip_parameter(contact.get(), 99, &number)), "99") &&
           stickslip_variable_name(contact.get(), 7, 0) == nullptr;
}

// Two threads may use the same model: each call is whole.
void share(const Model &contact) {
    std::vector<std::thread> threads;
    for (int thread = 0; thread < 4; ++thread) {
        threads.emplace_back([&contact] {
            for (int step = 0; step < 500; ++step) {
                need(stickslip_step(contact.get(), nullptr, 1e-3, nullptr));
            }
        });
    }
    for (auto &thread : threads) {
        thread.join();
    }
    double time = 0.0;
    need(stickslip_time(contact.get(), &time));
    if (std::fabs(time - 2.0) > 1e-9) {
        throw std::runtime_error("a step of a shared model was lost");
    }
}

} // namespace

int main(int argc, char **argv) try {
    std::ifstream file(argc == 2 ? argv[1] : "");
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const Model first = create(text);
    const auto expected = run(first, false);
    std::vector<std::vector<double>> found(8);
    std::vector<std::thread> threads;
    for (auto &forces : found) {
        threads.emplace_back([&first, &forces] { forces = run(copy(first), true); });
    }
    for (auto &thread : threads) {
        thread.join();
    }
    for (const auto &forces : found) {
        if (forces != expected) {
            throw std::runtime_error("a thread found another force");
        }
    }
    const Model shared = copy(first);
    need(stickslip_start(shared.get(), nullptr, 0.0, nullptr));
    share(shared);
    if (!refuses(first)) {
        throw std::runtime_error(std::string("wrong calls are not refused: ") + stickslip_error_text());
    }
    std::printf("%zu threads, %zu steps each: every force the same\n", found.size(), expected.size());
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
