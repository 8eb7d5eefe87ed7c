// Whitted's ray tracing: conicoid/integrators/whitted.py with conicoid/shading/{local,shadow}.py. What those do by
// calling each other is done here step by step, each step one walk through the scene.

const float FAINT = 2.44140625e-4;   // a ray that adds less than this share is not followed
const float FAINT_SHINE = 1e-5;

struct Pending {
    vec3 o, d, weight;
    int start, turns, medium;
};

Pending rays[RAYS];
int ray_count;

void push(Pending ray) {
    if (max(ray.weight.r, max(ray.weight.g, ray.weight.b)) < FAINT || ray_count >= RAYS) return;
    rays[ray_count++] = ray;
}

// tasks, one walk each
const int CAMERA_MEDIUM = 0, TAKE = 1, VISIBLE = 2, WALL = 3, SHADOW = 4, SHADOW_WALL = 5, SHADOW_MEDIA = 6;

uniform int u_depth;

// (linear rgb, 1 where the first ray meets a surface); `first` is what it meets
vec4 whitted_radiance(vec3 o, vec3 d) {
    vec3 sum = vec3(0.0);
    float covered = 0.0;
    ray_count = 0;
    int task = ANY_TRANSPARENT == 1 ? CAMERA_MEDIUM : TAKE;
    Pending now = Pending(o, d, vec3(1.0), NO_SURFACE, 0, OUTSIDE);
    if (task == TAKE) push(now);
    Ray ray;
    Hit hit, wall;
    Material m;
    int before = OUTSIDE, after = OUTSIDE, light_number = 0, mode = NEAREST;
    float t_min = 0.0;
    vec3 x, n, color, reflectance, transmitted, diffuse, shine, through, l_dir;
    bool refracts = false, from_inside = false, lit = false;
    float light_done = 0.0, light_part = 0.0, light_shine = 0.0, light_cosine = 0.0;
    int shadow_medium = OUTSIDE;
    for (int step = 0; step < STEPS; step++) {
        if (task == TAKE) {
            if (ray_count == 0) break;
            now = rays[--ray_count];
            t_min = 0.0;
            task = VISIBLE;
        }
        // One walk through the scene
        if (task == CAMERA_MEDIUM) { ray = Ray(o, vec3(0.0, 0.0, 1.0), 0.0, FAR, NO_SURFACE); mode = MEDIA_AT; }
        else if (task == VISIBLE) { ray = Ray(now.o, now.d, t_min, FAR, now.start); mode = NEAREST; }
        else if (task == WALL) { ray = Ray(now.o, now.d, hit.t, FAR, now.start); mode = MEDIA_AT; }
        else if (task == SHADOW) mode = BLOCKED;
        else if (task == SHADOW_WALL) mode = NEAREST;
        else { ray.t_min = wall.t; mode = MEDIA_AT; }
        Hit found = traverse(ray, mode, 0x7fffffff);
        bool shade = false, shadow_done = false;

        if (task == CAMERA_MEDIUM) {
            now.medium = medium_of(found.media.y);
            push(now);
            task = TAKE;
            continue;
        } else if (task == VISIBLE) {
            hit = found;
            if (hit.body < 0) {
                sum += absorbed(now.medium, FAR, now.weight) * background_color(now.d.z);
                task = TAKE;
                continue;
            }
            if (now.turns == 0) covered = 1.0;
            if (hit.surface == CUT) {
                // The cut of the section plane shows the body's own colour, flat
                m = material(material_row(hit.body, -1));
                vec3 flat_color = max(max(m.color.r, m.color.g), m.color.b) * m.diffuse > 0.02 ? m.color : vec3(0.35, 0.55, 0.75);
                if ((flags_of(hit.body) & TINTED) != 0)
                    flat_color = surface_color(m, hit.body, -1, CUT, now.o + hit.t * now.d, u_section.xyz);
                sum += now.weight * flat_color * 0.9;
                task = TAKE;
                continue;
            }
            before = after = OUTSIDE;
#if ANY_TRANSPARENT
            task = WALL;
            continue;
#else
            shade = true;
#endif
        } else if (task == WALL) {
            before = medium_of(found.media.x);
            after = medium_of(found.media.y);
            shade = (flags_of(hit.body) & MEDIUM) == 0 || before != after;
            if (!shade) {
                t_min = hit.t;
                task = VISIBLE;
                continue;
            }
        } else if (task == SHADOW) {
            through = vec3(found.body >= 0 ? 0.0 : 1.0);
            shadow_done = found.body >= 0 || ANY_TRANSPARENT == 0;
            light_done = 0.0;
            shadow_medium = before;
            if (!shadow_done) { task = SHADOW_WALL; continue; }
        } else if (task == SHADOW_WALL) {
            wall = found;
            if (wall.body >= 0) { task = SHADOW_MEDIA; continue; }
            through = absorbed(shadow_medium, (ray.t_max - light_done) * length(l_dir), through);
            shadow_done = true;
        } else {
            int inside = medium_of(found.media.x), beyond = medium_of(found.media.y);
            if ((flags_of(wall.body) & MEDIUM) == 0 || inside != beyond) {
                float size = length(l_dir);
                through = absorbed(inside, (wall.t - light_done) * size, through);
                vec3 normal = normal_at(wall.surface, wall.side, x + wall.t * l_dir);
                float cosine = abs(dot(l_dir, normal)) / size;
                float kept = 1.0 - wall_reflectance(cosine, index_of(inside), index_of(beyond));
                through *= kept * material(medium_of(wall.body)).transparency;
                shadow_medium = beyond;
                light_done = wall.t;
            }
            task = SHADOW_WALL;
            continue;
        }

        if (shade) {
            // The surface there, its normal turned to the eye
            now.weight = absorbed(before, hit.t, now.weight);
            m = material(material_row(hit.body, hit.face));
            x = on_surface(hit.surface, now.o + hit.t * now.d);
            n = normal_at(hit.surface, hit.side, x);
            color = surface_color(m, hit.body, hit.face, hit.surface, x, n);
            float cosine = -dot(n, now.d);
            from_inside = cosine < 0.0;
            if (from_inside) { n = -n; cosine = -cosine; }
            // How light parts there
            refracts = (flags_of(hit.body) & MEDIUM) != 0;
            reflectance = opaque_reflectance(m, cosine);
            transmitted = now.d;
            if (refracts) {
                float eta = index_of(before) / index_of(after);
                vec4 bent = refracted(now.d, n, eta);
                transmitted = bent.xyz;
                reflectance = vec3(dielectric(cosine, bent.w, eta));
            }
            lit = !(refracts && from_inside);
            diffuse = shine = vec3(0.0);
            light_number = lit ? 0 : u_light_count;
        }
        if (shadow_done) {
            vec3 arrived = through * light_part * light_at(light_number).intensity;
            diffuse += arrived * light_cosine;
            shine += arrived * light_shine;
            light_number++;
        }
        // The next light that could add something
        bool waiting = false;
        for (; light_number < u_light_count; light_number++) {
            Light light = light_at(light_number);
            vec4 to = towards(light, x);
            float distance = length(to.xyz);
            if (distance == 0.0) continue;
            vec3 l = to.xyz / distance;
            light_cosine = dot(n, l);
            if (light_cosine <= 0.0) continue;
            light_shine = m.specular.r + m.specular.g + m.specular.b > 0.0 ? highlight(m, l, -now.d, n) : 0.0;
            light_part = share(light, l, distance);
            if (light_part == 0.0 || (m.diffuse == 0.0 && light_shine < FAINT_SHINE)) continue;
            l_dir = to.xyz;
            ray = Ray(x, l_dir, 0.0, to.w, hit.surface);
            waiting = true;
            break;
        }
        if (waiting) { task = SHADOW; continue; }
        // Its own light
        if (lit) sum += now.weight * (color * (m.ambient * u_ambient + m.diffuse * diffuse)
                                      * (1.0 - reflectance) * (1.0 - m.transparency) + m.specular * shine);
        // On along the refracted and the mirrored ray
        task = TAKE;
        if (now.turns == u_depth) continue;
        push(Pending(x, transmitted, now.weight * (1.0 - reflectance) * m.transparency, hit.surface, now.turns + 1,
                     refracts ? after : before));
        push(Pending(x, reflect(now.d, n), now.weight * reflectance, hit.surface, now.turns + 1, before));
    }
    return vec4(sum, covered);
}
