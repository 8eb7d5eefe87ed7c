// The film on the screen: the mean of the samples as sRGB.

uniform sampler2D u_film;
uniform float u_samples;
uniform vec2 u_film_size, u_screen_size;
out vec4 color;

void main() {
    vec4 sum = texture(u_film, gl_FragCoord.xy / u_screen_size);
    vec3 c = clamp(sum.rgb / u_samples, 0.0, 1.0);
    color = vec4(mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308))), 1.0);
}
