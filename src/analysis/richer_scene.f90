!> Scene with more coordinates of its flexible bodies. The deck that describes it, and the way of motions from one to the other.
!> Floor: analysis. Source: doc/theory, eq. (7.49).
module limber_analysis_richer_scene
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_scene_scene, only: scene_type
   use limber_deck_content, only: deck_type
   use limber_beam_frame_reduction, only: available_frame_modes
   use limber_beam_beam_mesh, only: nodal_masses, nodal_inertias
   use limber_beam_beam_reduction, only: available_modes, point_shape
   use limber_beam_exact_beam, only: exact_type, panel_stations
   use limber_beam_exact_profile, only: of_ei, of_ea, of_ga
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_taut_axis, only: locate, values_at
   use limber_model_element_effects, only: acting_points
   use limber_model_points_of_action, only: acting_type
   use limber_model_model, only: body_type
   use limber_model_beam_segments, only: name_in_deck
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: richer_deck, richer_words, can_enrich, project_coordinates

   !> What a body gets: nothing, static responses to all that acts on it, more modes, both; an exact beam twice the functions of the
   !> angle, and of the strain as well
   integer, parameter, public :: nothing_more = 0, with_responses = 1, with_modes = 2, with_both = 3, with_angles = 4, &
      & with_functions = 5

   !> Additional axial modes of a beam, at least
   integer, parameter :: few_axial = 4

contains

   !> Whether a body has modes, of which there may be more.
   elemental logical function can_enrich(body)
      type(body_type), intent(in) :: body
      can_enrich = body%reduced%n > 0 .and. .not. body%reduced%is_exact
   end function can_enrich

   !> The deck with more coordinates of its bodies, without damping and scalars, and without given deflections, which mean the
   !> coordinates that it has.
   function richer_deck(scene, level, extra, with_outputs) result(deck)
      type(scene_type), intent(in) :: scene
      !> What each body gets (bodies), and the number of additional modes
      integer, intent(in) :: level(:), extra
      !> Whether it keeps its outputs
      logical, intent(in) :: with_outputs
      type(deck_type) :: deck
      integer :: i, block, modes(2)
      deck = scene%deck
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword == 'ASSEMBLY') deck%blocks(i)%lines = deck%blocks(i)%lines(:0)
         ! Blocks keep their places: this becomes one that no model is made of
         if (any(deck%blocks(i)%keyword == [character(7) :: 'SCALAR', 'DAMPING'])) deck%blocks(i)%keyword = 'STUDY'
         if (deck%blocks(i)%keyword == 'OUTPUT' .and. .not. with_outputs) deck%blocks(i)%keyword = 'STUDY'
      end do
      do i = 1, size(level)
         if (level(i) == nothing_more) cycle
         block = block_of(scene, i)
         if (level(i) >= with_angles) then
            associate (choice => scene%system%model%bodies(i)%choice%exact)
               call deck%set_number(block, 'FUNCTIONS', real(2*choice%angles, wp), given=.true.)
               if (level(i) == with_functions) &
                  & call deck%set_number(block, 'STRAIN FUNCTIONS', real(max(2, 2*choice%strains), wp), given=.true.)
            end associate
            cycle
         end if
         if (any(level(i) == [with_responses, with_both])) call deck%set_option(block, 'CORRECTIONS', 'YES', given=.true.)
         if (level(i) == with_responses) cycle
         modes = more_modes(scene, i, extra)
         if (scene%system%model%bodies(i)%is_frame) then
            call forget(deck, block, 'FREQUENCY LIMIT')
            call deck%set_number(block, 'MODES', real(sum(modes), wp), given=.true.)
         else
            call deck%set_number(block, 'BENDING MODES', real(modes(1), wp), given=.true.)
            call deck%set_number(block, 'AXIAL MODES', real(modes(2), wp), given=.true.)
            call deck%set_option(block, 'AXIAL BASIS', 'MODES')
            call deck%set_number(block, 'ELEMENTS', real(elements_for(scene, i, modes), wp))
         end if
      end do
   end function richer_deck

   !> Leaves an option open.
   pure subroutine forget(deck, block, name)
      type(deck_type), intent(inout) :: deck
      integer, intent(in) :: block
      character(*), intent(in) :: name
      integer :: i
      do i = 1, size(deck%blocks(block)%options)
         associate (option => deck%blocks(block)%options(i))
            if (option%name /= name) cycle
            option%given = .false.
            option%has_value = .false.
            option%text = ''
            option%value = 0.0_wp
         end associate
      end do
   end subroutine forget

   !> Index of the block of a body.
   pure integer function block_of(scene, body) result(block)
      type(scene_type), intent(in) :: scene
      integer, intent(in) :: body
      block = scene%deck%find_named('BEAM|FRAME', name_in_deck(scene%system%model, body))
   end function block_of

   !> Bending and axial modes of a beam, or modes of a frame (and 0): so many more than there are coordinates; of a frame not all
   !> that its mesh has, for its masses must let the responses be independent of them.
   function more_modes(scene, body, extra) result(modes)
      type(scene_type), intent(in) :: scene
      !> Index of the body
      integer, intent(in) :: body, extra
      integer :: modes(2)
      type(acting_type), allocatable :: points(:)
      call acting_points(scene%deck, name_in_deck(scene%system%model, body), points)
      associate (own => scene%system%model%bodies(body), forces => count(points%force), couples => count(points%couple))
         if (own%is_frame) then
            modes = [limited(available_frame_modes(own%mesh, own%frame_choice), own%reduced%n + extra, 2*forces + couples), 0]
         else
            modes = [own%reduced%bending + extra, own%reduced%n - own%reduced%bending + max(few_axial, extra/2)]
         end if
      end associate

   contains

      elemental integer function limited(available, wanted, responses)
         integer, intent(in) :: available, wanted, responses
         limited = min(wanted, max(available - responses, available/2))
      end function limited

   end function more_modes

   !> Elements of a beam that let so many modes, and responses, be.
   integer function elements_for(scene, body, modes) result(elements)
      type(scene_type), intent(in) :: scene
      !> Index of the body; modes of both kinds (2)
      integer, intent(in) :: body, modes(2)
      type(acting_type), allocatable :: points(:)
      integer :: available(2)
      call acting_points(scene%deck, name_in_deck(scene%system%model, body), points)
      elements = scene%deck%blocks(block_of(scene, body))%integer('ELEMENTS')
      associate (own => scene%system%model%bodies(body))
         available = available_modes(own%beam, own%choice)
      end associate
      if (any(available < modes + 2*size(points))) elements = max(elements, 2*(maxval(modes) + 2*size(points)))
   end function elements_for

   !> What a body gets as options of its block; empty if it has them already.
   function richer_words(scene, body, level, extra) result(text)
      type(scene_type), intent(in) :: scene
      !> Index of the body, what it gets, and the number of additional modes
      integer, intent(in) :: body, level, extra
      character(:), allocatable :: text
      integer :: modes(2), elements
      text = ''
      associate (own => scene%system%model%bodies(body))
         if (level /= with_modes .and. .not. scene%deck%blocks(block_of(scene, body))%yes('CORRECTIONS')) text = 'CORRECTIONS=YES'
         if (level /= with_responses) then
            modes = more_modes(scene, body, extra)
            if (text /= '') text = text//', '
            if (own%is_frame) then
               text = text//'MODES='//as_text(modes(1))
            else
               text = text//'BENDING MODES='//as_text(modes(1))//', AXIAL MODES='//as_text(modes(2))
               elements = elements_for(scene, body, modes)
               if (elements > scene%deck%blocks(block_of(scene, body))%integer('ELEMENTS')) &
                  & text = text//', ELEMENTS='//as_text(elements)
               if (scene%deck%blocks(block_of(scene, body))%given('AXIAL BASIS') .and. own%choice%static_axial) &
                  & text = text//', AXIAL BASIS=MODES'
            end if
         else if (text /= '' .and. own%choice%static_axial .and. .not. own%is_frame) then
            ! Not the default any more with this option
            if (.not. scene%deck%blocks(block_of(scene, body))%given('AXIAL BASIS')) text = text//', AXIAL BASIS=STATIC'
         end if
      end associate
   end function richer_words

   !> Coordinates or rates of a scene in the coordinates of another that differs by those of its flexible bodies, eq. (7.49).
   subroutine project_coordinates(system, other, from, to, rates)
      type(system_type), intent(in) :: system, other
      !> (nq or nw of each)
      real(wp), intent(in) :: from(:)
      real(wp), intent(inout) :: to(:)
      !> Whether they are rates
      logical, intent(in), optional :: rates
      integer :: i, a, b, head
      do i = 1, size(system%model%bodies)
         a = system%layout%q(i)
         b = other%layout%q(i)
         head = merge(4, 2, system%layout%framed(i))
         if (present(rates)) then
            a = system%layout%w(i)
            b = other%layout%w(i)
            head = system%layout%rates(i)
         end if
         to(b:b + head - 1) = from(a:a + head - 1)
         associate (n => system%layout%n(i), m => other%layout%n(i))
            if (m == 0) cycle
            if (can_enrich(system%model%bodies(i))) then
               to(b + head:b + head + m - 1) = matmul(overlap(other%model%bodies(i), system%model%bodies(i)), &
                  & from(a + head:a + head + n - 1))
            else if (system%model%bodies(i)%reduced%is_exact .and. m /= n) then
               to(b + head:b + head + m - 1) = matmul(exact_overlap(other%model%bodies(i)%reduced, &
                  & system%model%bodies(i)%reduced%exact), from(a + head:a + head + n - 1))
            else
               to(b + head:b + head + m - 1) = from(a + head:a + head + n - 1)
            end if
         end associate
      end do
   end subroutine project_coordinates

   !> Products of the functions of two exact beams in the strain energy (coordinates of a, of b).
   pure function exact_overlap(a, b) result(products)
      type(reduced_type), intent(in) :: a
      type(exact_type), intent(in) :: b
      real(wp) :: products(a%n, b%n), curvature(b%angles), strain(b%strains), row(panel_stations), x
      integer :: i, k, d, first, panel
      products = 0.0_wp
      associate (own => a%exact, m => a%exact%angles, n => b%angles)
         do k = 1, own%stations
            call locate(b, own%s(k), .false., panel, x)
            row = values_at(x)
            first = panel_stations*(panel - 1)
            curvature = matmul(b%kappa(:, first + 1:first + panel_stations), row)
            do i = 1, n
               products(:m, i) = products(:m, i) + own%weight(k)*own%section(of_ei, k)*own%kappa(:, k)*curvature(i)
            end do
            do d = 1, 2
               strain = matmul(b%chi(d, :, first + 1:first + panel_stations), row)
               do i = 1, b%strains
                  products(m + 1:, n + i) = products(m + 1:, n + i) + own%weight(k)*own%section(merge(of_ea, of_ga, d == 1), k) &
                     & *own%chi(d, :, k)*strain(i)
               end do
            end do
         end do
      end associate
      do i = 1, a%n
         products(i, :) = products(i, :)/a%omega2(i)
      end do
   end function exact_overlap

   !> Products of the shapes of two reductions of a body in its mass (coordinates of a, of b).
   function overlap(a, b) result(products)
      type(body_type), intent(in) :: a, b
      real(wp) :: products(a%reduced%n, b%reduced%n)
      real(wp), allocatable :: mass(:), inertia(:), phi(:, :), psi(:)
      integer :: i, j, k, p, q
      products = 0.0_wp
      if (a%is_frame) then
         do j = 1, size(products, 2)
            do i = 1, size(products, 1)
               products(i, j) = sum(a%mesh%mass*a%shape(:, :, i)*b%shape(:, :, j))
            end do
         end do
         return
      end if
      p = a%reduced%bending
      q = b%reduced%bending
      allocate (mass(0:a%beam%elements), source=nodal_masses(a%beam))
      allocate (inertia(0:a%beam%elements), source=nodal_inertias(a%beam))
      do k = 0, a%beam%elements
         call point_shape(b%field, a%field%s(k), phi, psi)
         do j = 1, q
            products(:p, j) = products(:p, j) + mass(k)*a%field%w(k, :)*phi(2, j) + inertia(k)*a%field%theta(k, :)*psi(j)
         end do
         do j = q + 1, size(products, 2)
            products(p + 1:, j) = products(p + 1:, j) + mass(k)*a%field%u(k, :)*phi(1, j)
         end do
      end do
   end function overlap

end module limber_analysis_richer_scene
