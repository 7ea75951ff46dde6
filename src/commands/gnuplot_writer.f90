!> Drawings as data blocks for gnuplot. Floor: commands; `limber_commands_drawing` leads it.
module limber_commands_gnuplot_writer
   use limber_base_kinds, only: wp
   use limber_base_text, only: one_line
   implicit none
   private
   public :: gnuplot_writer_type

   !> A pen on an open unit
   type :: gnuplot_writer_type
      integer :: unit = 0
      !> Whether a write has failed
      logical :: failed = .false.
      !> Layer, whether it has been started, and whether any has
      character(16), private :: layer = ''
      logical, private :: layer_started = .false., any_started = .false.
   contains
      procedure :: remark, begin, stroke, circle, foot, hatched_edge, zigzag, block, wheel, belt
   end type gnuplot_writer_type

   !> Strokes of the hatch under a foot
   integer, parameter :: strokes_of_foot = 5
   !> Strokes of the hatch of a line, at most
   real(wp), parameter :: most_strokes = 300.0_wp

contains

   !> A line that gnuplot does not read; a text of several lines becomes one.
   subroutine remark(self, text)
      class(gnuplot_writer_type), intent(inout) :: self
      character(*), intent(in) :: text
      call put(self, '')
      call put(self, '')
      call put(self, '# '//one_line(text))
      self%any_started = .false.
   end subroutine remark

   !> Goes on to another layer.
   subroutine begin(self, layer)
      class(gnuplot_writer_type), intent(inout) :: self
      character(*), intent(in) :: layer
      self%layer = layer
      self%layer_started = .false.
   end subroutine begin

   !> A line through points.
   subroutine stroke(self, points, body)
      class(gnuplot_writer_type), intent(inout) :: self
      !> (2, points) [length]
      real(wp), intent(in) :: points(:, :)
      !> Number of its body, 0 the ground
      integer, intent(in) :: body
      integer :: i, status
      if (self%layer_started) call put(self, '')
      call start(self)
      do i = 1, size(points, 2)
         write (self%unit, '(2(es16.8e3,1x),i0)', iostat=status) points(:, i), body
         self%failed = self%failed .or. status /= 0
      end do
   end subroutine stroke

   !> A circle.
   subroutine circle(self, centre, body, radius)
      class(gnuplot_writer_type), intent(inout) :: self
      real(wp), intent(in) :: centre(2), radius
      integer, intent(in) :: body
      integer :: status
      call start(self)
      write (self%unit, '(2(es16.8e3,1x),i0,es16.8e3)', iostat=status) centre, body, radius
      self%failed = self%failed .or. status /= 0
   end subroutine circle

   !> The hatched foot of a pin.
   subroutine foot(self, pin, down, size)
      class(gnuplot_writer_type), intent(inout) :: self
      !> Where the pin is, a unit vector from there to the foot (2), size of symbols
      real(wp), intent(in) :: pin(2), down(2), size
      real(wp) :: right(2), base(2)
      right = [-down(2), down(1)]
      base = pin + 1.9_wp*size*down
      call self%stroke(reshape([base - 1.1_wp*size*right, pin, base + 1.1_wp*size*right], [2, 3]), 0)
      call self%hatched_edge(base, right, down, 1.7_wp*size, size)
   end subroutine foot

   !> A line with a hatch on one side.
   subroutine hatched_edge(self, middle, along, down, half, size)
      class(gnuplot_writer_type), intent(inout) :: self
      !> Middle of the line, unit vectors along it and to the hatched side (2), half its length, size of symbols
      real(wp), intent(in) :: middle(2), along(2), down(2), half, size
      real(wp) :: from(2)
      integer :: i, n
      call self%stroke(reshape([middle - half*along, middle + half*along], [2, 2]), 0)
      n = max(strokes_of_foot, nint(min(2*half/(0.7_wp*size), most_strokes)))
      do i = 1, n
         from = middle + (2*half*i/n - half)*along
         call self%stroke(reshape([from, from + 0.65_wp*size*(down - along)], [2, 2]), 0)
      end do
   end subroutine hatched_edge

   !> A spring between two points.
   subroutine zigzag(self, from, to, body, size)
      class(gnuplot_writer_type), intent(inout) :: self
      !> The points (2), and size of symbols
      real(wp), intent(in) :: from(2), to(2), size
      integer, intent(in) :: body
      integer, parameter :: turns = 12
      real(wp) :: points(2, turns + 4), ahead(2), aside(2), distance
      integer :: i
      distance = norm2(to - from)
      if (.not. distance > 0.0_wp) return
      ahead = to - from
      aside = 0.8_wp*size/distance*[-ahead(2), ahead(1)]
      points(:, 1) = from
      points(:, 2) = from + 0.15_wp*ahead
      do i = 1, turns
         points(:, i + 2) = from + (0.15_wp + 0.7_wp*(i - 0.5_wp)/turns)*ahead + merge(1, -1, mod(i, 2) == 1)*aside
      end do
      points(:, turns + 3) = from + 0.85_wp*ahead
      points(:, turns + 4) = to
      call self%stroke(points, body)
   end subroutine zigzag

   !> A rectangle.
   subroutine block(self, middle, along, half, body)
      class(gnuplot_writer_type), intent(inout) :: self
      !> Its middle, a unit vector along it (2), half its length and height (2)
      real(wp), intent(in) :: middle(2), along(2), half(2)
      integer, intent(in) :: body
      real(wp) :: a(2), b(2)
      a = half(1)*along
      b = half(2)*[-along(2), along(1)]
      call self%stroke(reshape([middle - a - b, middle + a - b, middle + a + b, middle - a + b, middle - a - b], [2, 5]), body)
   end subroutine block

   !> A wheel with one radius.
   subroutine wheel(self, centre, axis, radius, body)
      class(gnuplot_writer_type), intent(inout) :: self
      !> Its centre, unit vector along the radius (2), and length of it
      real(wp), intent(in) :: centre(2), axis(2), radius
      integer, intent(in) :: body
      integer, parameter :: corners = 48
      real(wp) :: points(2, corners + 2), angle
      integer :: i
      points(:, 1) = centre
      do i = 0, corners
         angle = 2*acos(-1.0_wp)*i/corners
         points(:, i + 2) = centre + radius*(cos(angle)*axis + sin(angle)*[-axis(2), axis(1)])
      end do
      call self%stroke(points, body)
   end subroutine wheel

   !> The two straight parts of a belt around two wheels; nothing if one is inside the other.
   subroutine belt(self, centres, radii, crossed)
      class(gnuplot_writer_type), intent(inout) :: self
      !> Centres (2,2) and radii of the wheels
      real(wp), intent(in) :: centres(2, 2), radii(2)
      logical, intent(in) :: crossed
      real(wp) :: ahead(2), side, second, distance, normal(2)
      integer :: i
      distance = norm2(centres(:, 2) - centres(:, 1))
      second = merge(-radii(2), radii(2), crossed)
      if (distance <= abs(radii(1) - second)) return
      ahead = (centres(:, 2) - centres(:, 1))/distance
      do i = -1, 1, 2
         side = i*sqrt(1 - ((radii(1) - second)/distance)**2)
         normal = (radii(1) - second)/distance*ahead + side*[-ahead(2), ahead(1)]
         call self%stroke(reshape([centres(:, 1) + radii(1)*normal, centres(:, 2) + second*normal], [2, 2]), 0)
      end do
   end subroutine belt

   !> Writes the name of the layer before its first stroke.
   subroutine start(self)
      class(gnuplot_writer_type), intent(inout) :: self
      if (self%layer_started) return
      if (self%any_started) then
         call put(self, '')
         call put(self, '')
      end if
      call put(self, '# '//trim(self%layer))
      self%layer_started = .true.
      self%any_started = .true.
   end subroutine start

   subroutine put(self, line)
      class(gnuplot_writer_type), intent(inout) :: self
      character(*), intent(in) :: line
      integer :: status
      write (self%unit, '(a)', iostat=status) line
      self%failed = self%failed .or. status /= 0
   end subroutine put

end module limber_commands_gnuplot_writer
