// A pixel of the picture: linear light in rgb, in alpha 1 where something is hit. Samples add up in the page's film.

uniform sampler2D u_film;
uniform bool u_xray;
uniform float u_chord_scale;
out vec4 pixel_sum;

void main() {
    vec2 pixel = gl_FragCoord.xy;
    noise_state = uint(gl_FragCoord.x) * 1973u + uint(gl_FragCoord.y) * 9277u + uint(u_sample) * 26699u + 1u;
    noise();
    if (u_sample > 0) pixel += vec2(noise(), noise()) - 0.5;
    Ray ray = camera_ray(pixel);
    vec4 color;
    if (u_xray) {
        float chord = traverse(ray, THROUGH, 0x7fffffff).chord;
        color = vec4(vec3(exp(-chord * u_chord_scale)), chord > 0.0 ? 1.0 : 0.0);
    } else {
        color = whitted_radiance(ray.o, ray.d);
    }
    vec4 before = u_sample > 0 ? texelFetch(u_film, ivec2(gl_FragCoord.xy), 0) : vec4(0.0);
    pixel_sum = before + color;
}
